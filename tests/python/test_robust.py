"""Robust laws through NumPy; the C++ tests hold the comparison with Ceres."""

import copy
import pickle

import numpy as np
import pytest

import raylign
from raylign.robust import Loss, LossType

S = np.geomspace(1e-8, 1e6, 200)

# Written down a second time, from the table of the documentation; a = scale, nu = 4.
REFERENCE = {
    LossType.TRIVIAL: lambda s, a: s,
    LossType.HUBER: lambda s, a: np.where(s <= a**2, s, 2 * a * np.sqrt(s) - a**2),
    LossType.SOFT_L1: lambda s, a: 2 * a**2 * (np.sqrt(1 + s / a**2) - 1),
    LossType.CAUCHY: lambda s, a: a**2 * np.log1p(s / a**2),
    LossType.ARCTAN: lambda s, a: a * a * np.arctan(s / (a * a)),
    LossType.TUKEY: lambda s, a: a**2 / 3 * (1 - (1 - np.minimum(s / a**2, 1)) ** 3),
    LossType.GEMAN_MCCLURE: lambda s, a: s / (1 + s / a**2),
    LossType.STUDENT_T: lambda s, a: 4 * a**2 * np.log1p(s / (4 * a**2)),
}


@pytest.fixture(params=list(LossType), ids=lambda law: law.name.lower())
def law(request) -> LossType:
    return request.param


def loss_of(law: LossType, scale: float) -> Loss:
    return Loss(type=law, scale=scale, degrees_of_freedom=4.0)


@pytest.mark.parametrize("scale", [0.3, 1.0, 20.0])
def test_values(law, scale):
    rho, _, _ = loss_of(law, scale).evaluate(S)
    np.testing.assert_allclose(rho, REFERENCE[law](S, scale), rtol=1e-12, atol=1e-13 * scale**2)


@pytest.mark.parametrize("scale", [0.3, 1.0, 20.0])
def test_derivatives(law, scale):
    s = scale**2 * np.array([1e-3, 0.1, 0.5, 0.9, 1.1, 3.0, 100.0])
    h = 1e-4 * s
    loss = loss_of(law, scale)
    _, d_rho, d2_rho = loss.evaluate(s)
    forward, backward = loss.evaluate(s + h), loss.evaluate(s - h)
    np.testing.assert_allclose(d_rho, (forward[0] - backward[0]) / (2 * h), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(d2_rho, (forward[1] - backward[1]) / (2 * h), rtol=1e-5, atol=1e-8)


def test_starts_as_least_squares(law):
    assert [float(x) for x in loss_of(law, 2.0).evaluate(0.0)[:2]] == [0.0, 1.0]


def test_shapes():
    loss = Loss.parse("cauchy:2.0")
    for shape in [(), (0,), (3,), (2, 3)]:
        assert [x.shape for x in loss.evaluate(np.ones(shape))] == [shape] * 3
    assert np.array_equal(loss.evaluate([1, 4])[0], loss.evaluate(np.array([1.0, 4.0]))[0])
    with pytest.raises(raylign.ShapeError, match="squared_norm"):
        loss.evaluate("one")


def test_default_is_least_squares():
    assert Loss() == Loss(type=LossType.TRIVIAL, scale=1.0, degrees_of_freedom=5.0)


def test_parse(law):
    assert Loss.parse(law.name.lower()) == Loss(type=law)
    assert Loss.parse(f"{law.name.lower()}:2.5") == Loss(type=law, scale=2.5)


def test_parse_degrees_of_freedom():
    expected = Loss(type=LossType.STUDENT_T, scale=0.5, degrees_of_freedom=7.0)
    assert Loss.parse("student_t:0.5:7") == expected


@pytest.mark.parametrize(
    "text", ["", "hubert", "Huber", "huber:", "huber:x", "huber:-1", "huber:nan", "huber:1:5", ":1"]
)
def test_parse_refuses(text):
    with pytest.raises(raylign.OptionsError):
        Loss.parse(text)


def test_options_contract(law):
    loss = loss_of(law, 1.5)
    assert eval(repr(loss)) == loss
    assert pickle.loads(pickle.dumps(loss)) == copy.copy(loss) == copy.deepcopy(loss) == loss
    assert loss.replace(scale=2.0).scale == 2.0
    assert loss.to_dict() == {"type": law, "scale": 1.5, "degrees_of_freedom": 4.0}
    with pytest.raises(TypeError):
        Loss("huber")
    assert Loss(type=law.name.lower()).type is law
    with pytest.raises(raylign.OptionsError, match=r"Loss\.type must be one of"):
        Loss(type="hubr")
    with pytest.raises(raylign.OptionsError, match=r"Loss\.type must be like"):
        Loss(type=3)
    with pytest.raises(TypeError, match="scal"):
        Loss(scal=1.0)


@pytest.mark.parametrize("field", ["scale", "degrees_of_freedom"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_values(field, value):
    with pytest.raises(raylign.OptionsError, match=f"Loss.{field} must be > 0"):
        Loss(**{field: value})


@pytest.mark.parametrize("loss_type", list(LossType), ids=lambda t: t.name)
def test_scale_is_in_units_of_the_residual(loss_type):
    """Residuals and scale in another unit: the same law, ρ in the unit squared."""
    s = np.array([0.0, 0.5, 3.0, 400.0])
    one = Loss(type=loss_type, scale=1.0).evaluate(s)[0]
    ten = Loss(type=loss_type, scale=10.0).evaluate(100.0 * s)[0]
    np.testing.assert_allclose(ten, 100.0 * one, rtol=1e-13)
