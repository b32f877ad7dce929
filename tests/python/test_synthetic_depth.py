"""`raylign.synthetic.sense_depth` and `noise_field`: noise and holes as asked."""

import numpy as np
import pytest

from raylign import synthetic
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.depth import DepthModel
from raylign.errors import OptionsError, ShapeError
from raylign.synthetic import DepthSensorOptions

CAMERA = PinholeCamera(260.0, 260.0, 159.5, 119.5)
SIZE = {"width": 320, "height": 240}
UNIFORM = synthetic.TextureOptions(kind="uniform")
# No noise, no rounding, no holes.
PERFECT = DepthSensorOptions(
    noise=0.0,
    inverse_depth_step=0.0,
    max_incidence_deg=90.0,
    model=DepthModel(edge_radius=0, edge_ratio=0.0),
)


@pytest.fixture(scope="module")
def wall() -> synthetic.Frame:
    scene = synthetic.plane(slant_deg=0.0, distance=2.0, texture=UNIFORM)
    return synthetic.render(scene, CAMERA, np.eye(4), **SIZE)


@pytest.fixture(scope="module")
def board() -> synthetic.Frame:
    scene = synthetic.plane(slant_deg=50.0, distance=2.5, texture=UNIFORM)
    scene.add(synthetic.board(distance=1.2, texture=UNIFORM))
    return synthetic.render(scene, CAMERA, np.eye(4), **SIZE)


def test_perfect_sensor_reports_the_truth(board: synthetic.Frame):
    depth = synthetic.sense_depth(board, CAMERA, options=PERFECT)
    assert depth.dtype == np.float32
    assert np.array_equal(depth, board.depth.astype(np.float32))
    distorted = RadtanCamera(260.0, 260.0, 159.5, 119.5, -0.2, 0.0, 0.0, 0.0)
    assert np.array_equal(synthetic.sense_depth(board, distorted, options=PERFECT), depth)


@pytest.mark.parametrize("length", [0.0, 3.0])
@pytest.mark.parametrize("law", ["kinect", "constant", "time_of_flight"])
def test_noise_has_the_sigma_of_the_model(wall: synthetic.Frame, law: str, length: float):
    model = DepthModel(noise=law, edge_radius=0, edge_ratio=0.0)
    options = PERFECT.replace(noise=2.0, model=model, correlation_length=length)
    error = [
        1.0 / synthetic.sense_depth(wall, CAMERA, options=options, seed=4, index=i) - 0.5
        for i in range(4)
    ]
    sigma = 2.0 * model.inverse_depth_sigma([2.0])[0]
    # Correlated pixels count for less: one per 4 pi l².
    num_free = 4 * 320 * 240 / max(1.0, 4.0 * np.pi * length**2)
    assert np.std(error) == pytest.approx(sigma, rel=4.0 / np.sqrt(2.0 * num_free))
    assert abs(np.mean(error)) < 5.0 * sigma / np.sqrt(num_free)
    assert not np.array_equal(error[0], error[1])


@pytest.mark.parametrize("length", [2.0, 5.0, 8.0])
def test_noise_field_has_its_correlation(length: float):
    field = np.stack(
        [
            synthetic.noise_field(**SIZE, correlation_length=length, seed=9, index=i)
            for i in range(12)
        ]
    )
    num_free = field.size / (4.0 * np.pi * length**2)
    assert field.var() == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / num_free))
    for d in (1, 3, 6, 12):
        expected = np.exp(-0.5 * (d / length) ** 2)
        tolerance = 4.0 * np.sqrt(2.0 / num_free)
        assert (field[:, d:] * field[:, :-d]).mean() == pytest.approx(expected, abs=tolerance)
        assert (field[..., d:] * field[..., :-d]).mean() == pytest.approx(expected, abs=tolerance)


def test_white_noise_is_white():
    field = synthetic.noise_field(**SIZE, seed=2)
    assert field.shape == (240, 320)
    assert field.var() == pytest.approx(1.0, abs=0.03)
    assert abs((field[1:] * field[:-1]).mean()) < 0.02
    assert np.array_equal(field, synthetic.noise_field(**SIZE, seed=2))
    small = synthetic.noise_field(width=10, height=7, seed=2)
    assert np.array_equal(small, field[:7, :10])


def test_inverse_depth_is_rounded(wall: synthetic.Frame):
    options = PERFECT.replace(noise=1.0, inverse_depth_step=0.01)
    steps = 1.0 / synthetic.sense_depth(wall, CAMERA, options=options).astype(float) / 0.01
    assert np.abs(steps - np.rint(steps)).max() < 1e-4
    assert len(np.unique(np.rint(steps))) > 1


def test_holes_near_steps_of_the_depth(board: synthetic.Frame):
    model = DepthModel(edge_radius=2, edge_ratio=0.1)
    depth = synthetic.sense_depth(board, CAMERA, options=PERFECT.replace(model=model))
    plate = np.isfinite(depth) & (board.face == 1)
    rows, columns = np.nonzero(board.face == 1)
    inner = board.face == 1
    inner[: rows.min() + 2] = inner[rows.max() - 1 :] = False
    inner[:, : columns.min() + 2] = inner[:, columns.max() - 1 :] = False
    assert np.array_equal(plate, inner)


def test_holes_at_grazing_angles_and_out_of_range(board: synthetic.Frame):
    v, u = np.mgrid[:240, :320]
    rays, _ = CAMERA.unproject(np.stack([u, v], axis=-1).astype(float))
    incidence = np.rad2deg(np.arccos(-(rays * board.normal).sum(axis=-1)))
    options = PERFECT.replace(max_incidence_deg=60.0)
    depth = synthetic.sense_depth(board, CAMERA, options=options)
    assert np.array_equal(np.isfinite(depth), incidence <= 60.0)
    assert 0.1 < np.isfinite(depth).mean() < 0.9
    model = DepthModel(edge_radius=0, edge_ratio=0.0, min_depth=1.5, max_depth=2.6)
    depth = synthetic.sense_depth(board, CAMERA, options=PERFECT.replace(model=model))
    assert np.array_equal(np.isfinite(depth), (board.depth >= 1.5) & (board.depth <= 2.6))


def test_dropout_is_the_fraction_asked_for(wall: synthetic.Frame):
    depth = synthetic.sense_depth(wall, CAMERA, options=PERFECT.replace(dropout=0.3), seed=1)
    assert np.isnan(depth).mean() == pytest.approx(0.3, abs=0.01)
    assert np.isnan(synthetic.sense_depth(wall, CAMERA, options=PERFECT.replace(dropout=1.0))).all()


def test_default_is_like_a_kinect(board: synthetic.Frame):
    """Some holes; noise of millimetres to centimetres."""
    depth = synthetic.sense_depth(board, CAMERA)
    known = np.isfinite(depth)
    assert 0.5 < known.mean() < 0.999
    relative = (depth - board.depth)[known] / board.depth[known] ** 2
    assert 0.001 < relative.std() < 0.004


def test_refusals(wall: synthetic.Frame):
    for name, value in (
        ("noise", -1.0),
        ("correlation_length", 65.0),
        ("inverse_depth_step", np.inf),
        ("max_incidence_deg", 0.0),
        ("dropout", 1.5),
    ):
        with pytest.raises(OptionsError, match=rf"DepthSensorOptions\.{name}"):
            DepthSensorOptions(**{name: value})
    with pytest.raises(OptionsError, match="correlation_length"):
        synthetic.noise_field(width=4, height=4, correlation_length=-1.0)
    with pytest.raises(ShapeError):
        synthetic.noise_field(width=0, height=4)
