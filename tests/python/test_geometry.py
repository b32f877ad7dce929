"""Group axioms and batch shapes through NumPy; SciPy's matrix functions are the oracle."""

from types import ModuleType

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import raylign
from raylign import geometry

DOF = {"so3": 3, "se3": 6, "sim3": 7}
SIZE = {"so3": 3, "se3": 4, "sim3": 4}
ANGLES = [0.0, 1e-12, 1e-8, 1e-5, 1e-2, 0.7, 2.0, 3.0, np.pi - 1e-6, np.pi - 1e-9]


class Group:
    """The functions of one group under common names."""

    def __init__(self, name: str, module: ModuleType = geometry) -> None:
        self.name = name
        self.dof = DOF[name]
        self.size = SIZE[name]
        for function in ("exp", "log", "hat", "vee", "adjoint", "left_jacobian", "right_jacobian"):
            setattr(self, function, getattr(module, f"{name}_{function}"))
        self.left_jacobian_inverse = getattr(module, f"{name}_left_jacobian_inverse")
        self.right_jacobian_inverse = getattr(module, f"{name}_right_jacobian_inverse")
        self.inverse = getattr(module, f"{name}_inverse", lambda R: np.swapaxes(R, -1, -2))

    def random(self, rng: np.random.Generator, angle: float, shape: tuple[int, ...] = ()):
        xi = rng.normal(size=(*shape, self.dof))
        start = 0 if self.name == "so3" else 3
        omega = xi[..., start : start + 3]
        omega *= angle / np.linalg.norm(omega, axis=-1, keepdims=True)
        return xi


@pytest.fixture(params=list(DOF))
def group(request) -> Group:
    return Group(request.param)


def rng_of(name: str) -> np.random.Generator:
    return np.random.default_rng(list(name.encode()))


@pytest.mark.parametrize("angle", ANGLES)
def test_exp_is_the_matrix_exponential(group, angle):
    xi = group.random(rng_of("exp"), angle)
    np.testing.assert_allclose(group.exp(xi), expm(group.hat(xi)), rtol=0, atol=1e-13)


@pytest.mark.parametrize("angle", ANGLES)
def test_log_inverts_exp(group, angle):
    xi = group.random(rng_of("log"), angle, (20,))
    np.testing.assert_allclose(group.log(group.exp(xi)), xi, rtol=0, atol=2e-13)


def test_group_axioms(group):
    rng = rng_of("axioms")
    a, b, c = (group.exp(group.random(rng, angle, (5,))) for angle in (0.5, 2.0, 3.0))
    identity = np.eye(group.size)
    assert np.array_equal(group.exp(np.zeros(group.dof)), identity)
    assert np.array_equal(group.log(identity), np.zeros(group.dof))
    np.testing.assert_allclose(a @ group.inverse(a), np.broadcast_to(identity, a.shape), atol=1e-14)
    np.testing.assert_allclose((a @ b) @ c, a @ (b @ c), atol=1e-13)


def test_adjoint_moves_tangents_across(group):
    rng = rng_of("adjoint")
    T = group.exp(group.random(rng, 2.0, (10,)))
    xi = group.random(rng, 0.7, (10,))
    moved = np.einsum("nij,nj->ni", group.adjoint(T), xi)
    np.testing.assert_allclose(
        T @ group.exp(xi) @ group.inverse(T), group.exp(moved), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("angle", [0.0, 1e-6, 0.5, 2.0, 3.1])
def test_jacobians_are_the_derivatives(group, angle):
    xi = group.random(rng_of("jacobian"), angle)
    inverse = group.inverse(group.exp(xi))
    h = 1e-5
    steps = h * np.eye(group.dof)
    forward, backward = group.exp(xi + steps), group.exp(xi - steps)
    left = (group.log(forward @ inverse) - group.log(backward @ inverse)).T / (2 * h)
    right = (group.log(inverse @ forward) - group.log(inverse @ backward)).T / (2 * h)
    np.testing.assert_allclose(group.left_jacobian(xi), left, rtol=0, atol=1e-8)
    np.testing.assert_allclose(group.right_jacobian(xi), right, rtol=0, atol=1e-8)
    identity = np.eye(group.dof)
    product = group.left_jacobian_inverse(xi) @ group.left_jacobian(xi)
    np.testing.assert_allclose(product, identity, rtol=0, atol=1e-12)
    product = group.right_jacobian_inverse(xi) @ group.right_jacobian(xi)
    np.testing.assert_allclose(product, identity, rtol=0, atol=1e-12)


def test_vee_inverts_hat(group):
    xi = group.random(rng_of("hat"), 1.0, (4,))
    np.testing.assert_allclose(group.vee(group.hat(xi)), xi, rtol=0, atol=1e-15)


def test_tangent_is_translation_first():
    T = geometry.se3_exp([1.0, 2.0, 3.0, 0.0, 0.0, 0.0])
    assert T[:3, 3].tolist() == [1.0, 2.0, 3.0]
    S = geometry.sim3_exp([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.log(2.0)])
    np.testing.assert_allclose(S, np.diag([2.0, 2.0, 2.0, 1.0]), rtol=1e-15)


@pytest.mark.parametrize("batch", [(), (0,), (1,), (5,), (2, 3), (2, 0, 3)])
def test_batch_shapes(group, batch):
    rng = rng_of("batch")
    xi = rng.normal(size=(*batch, group.dof))
    matrix, jacobian = (*batch, group.size, group.size), (*batch, group.dof, group.dof)
    T = group.exp(xi)
    assert T.shape == group.hat(xi).shape == group.inverse(T).shape == matrix
    assert group.log(T).shape == group.vee(group.hat(xi)).shape == xi.shape
    for function in ("left_jacobian", "right_jacobian"):
        assert getattr(group, function)(xi).shape == jacobian
        assert getattr(group, f"{function}_inverse")(xi).shape == jacobian
    assert group.adjoint(T).shape == jacobian
    assert T.dtype == np.float64
    assert T.flags.c_contiguous


def test_batch_is_item_by_item(group):
    xi = rng_of("items").normal(size=(2, 3, group.dof))
    T = group.exp(xi)
    for index in np.ndindex(2, 3):
        assert np.array_equal(T[index], group.exp(xi[index]))
        assert np.array_equal(group.log(T)[index], group.log(T[index]))
        assert np.array_equal(group.left_jacobian(xi)[index], group.left_jacobian(xi[index]))


def test_lists_views_and_other_real_dtypes_are_taken():
    T = geometry.se3_exp(np.ones((4, 6)))
    assert np.array_equal(geometry.so3_log(T[:, :3, :3]), geometry.so3_log(T[:, :3, :3].copy()))
    assert np.array_equal(
        geometry.so3_log(np.asfortranarray(T[0, :3, :3])), geometry.so3_log(T[0, :3, :3])
    )
    assert np.array_equal(geometry.so3_exp([1, 0, 0]), geometry.so3_exp(np.array([1.0, 0.0, 0.0])))
    assert np.array_equal(
        geometry.so3_exp(np.float32([0.5, 0, 0])), geometry.so3_exp([0.5, 0.0, 0.0])
    )


@pytest.mark.parametrize(
    "bad",
    [
        1.0,
        [1.0, 2.0],
        np.zeros((3, 4)),
        np.zeros(3, complex),
        np.zeros(3, bool),
        ["a", "b", "c"],
        None,
        [[1.0, 2.0, 3.0], [1.0]],
    ],
)
def test_what_is_no_batch_of_vectors_is_refused(bad):
    with pytest.raises(raylign.ShapeError, match=r"omega must be .*\(\.\.\., 3\), got"):
        geometry.so3_exp(bad)


def test_wrong_matrix_shape_is_refused():
    with pytest.raises(ValueError, match=r"T must be .*\(\.\.\., 4, 4\), got float64 \(3, 3\)"):
        geometry.se3_log(np.eye(3))


def test_quaternions_agree_with_scipy():
    rng = rng_of("quaternion")
    omega = rng.normal(size=(100, 3))
    rotation = Rotation.from_rotvec(omega)
    q = geometry.quaternion_exp(omega)
    np.testing.assert_allclose(geometry.quaternion_to_matrix(q), rotation.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(geometry.so3_exp(omega), rotation.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(geometry.quaternion_log(q), rotation.as_rotvec(), atol=1e-13)
    expected = rotation.as_quat()  # xyzw
    expected *= np.sign(expected[:, 3:])
    found = geometry.quaternion_from_matrix(rotation.as_matrix())
    np.testing.assert_allclose(found, expected, atol=1e-14)
    assert geometry.quaternion_exp([0.2, 0.0, 0.0])[3] == pytest.approx(np.cos(0.1))  # w is last


def test_log_at_pi():
    for axis in np.vstack([np.eye(3), rng_of("pi").normal(size=(10, 3))]):
        n = axis / np.linalg.norm(axis)
        R = 2.0 * np.outer(n, n) - np.eye(3)
        omega = geometry.so3_log(R)
        assert np.linalg.norm(omega) == pytest.approx(np.pi, abs=1e-14)
        np.testing.assert_allclose(np.abs(omega @ n), np.pi, rtol=1e-14)


def test_sim3_log_of_no_similarity_is_nan():
    assert np.isnan(geometry.sim3_log(np.diag([-1.0, 1.0, 1.0, 1.0]))).all()


class TestUmeyama:
    def points(self, count: int = 20):
        return np.array([5.0, 0.0, -2.0]) + rng_of("umeyama").normal(size=(count, 3))

    @pytest.mark.parametrize("with_scale", [True, False])
    def test_recovers_the_transform(self, with_scale):
        source = self.points()
        S = geometry.sim3_exp([1.0, -2.0, 0.5, 0.3, 1.1, -0.4, 0.8 if with_scale else 0.0])
        target = source @ S[:3, :3].T + S[:3, 3]
        found = geometry.umeyama(source, target, with_scale=with_scale)
        np.testing.assert_allclose(found, S, rtol=0, atol=1e-13)

    def test_without_scale_is_rigid(self):
        source = self.points()
        found = geometry.umeyama(source, 3.0 * source, with_scale=False)
        np.testing.assert_allclose(found[:3, :3], np.eye(3), atol=1e-13)

    @pytest.mark.parametrize(
        ("source", "target"),
        [
            (np.zeros((4, 3)), np.zeros((5, 3))),
            (np.zeros((2, 3)), np.zeros((2, 3))),
            (np.zeros((4, 2)), np.zeros((4, 2))),
            (np.zeros((4, 3), np.float32), np.zeros((4, 3), np.float32)),
            (np.zeros((4, 6))[:, ::2], np.zeros((4, 3))),
        ],
    )
    def test_shapes_that_do_not_fit(self, source, target):
        with pytest.raises(raylign.ShapeError):
            geometry.umeyama(source, target)

    def test_points_on_a_line(self):
        line = np.outer(np.arange(5.0), [1.0, 2.0, 3.0])
        with pytest.raises(raylign.Error, match="line"):
            geometry.umeyama(line, self.points(5))
