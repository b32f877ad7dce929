"""`raylign.synthetic.trajectory` and `render_sequence`."""

import itertools
import math

import numpy as np
import pytest

from raylign import synthetic
from raylign.camera import PinholeCamera
from raylign.errors import OptionsError, ShapeError
from raylign.geometry import se3_exp, se3_inverse, se3_log, so3_log
from raylign.synthetic import Motion, RenderOptions, SensorOptions

CAMERA = PinholeCamera(50.0, 50.0, 31.5, 23.5)
SIZE = {"width": 64, "height": 48}
START = se3_exp([0.3, -0.2, 0.1, 0.2, 0.4, -0.1])


@pytest.mark.parametrize("motion", Motion)
def test_paths_start_where_asked_and_are_smooth(motion: Motion):
    stamps, T_wc = synthetic.trajectory(motion, n=50, start=START, seed=3)
    assert stamps == pytest.approx(np.arange(50) / 30.0)
    assert np.abs(T_wc[0] - START).max() < 1e-12
    R = T_wc[:, :3, :3]
    assert np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max() < 1e-12
    steps = np.array([se3_log(se3_inverse(a) @ b) for a, b in itertools.pairwise(T_wc)])
    assert np.abs(np.diff(steps, axis=0)).max() < 2e-3
    same = synthetic.trajectory(motion.name.lower(), n=50, start=START, seed=3)[1]
    assert np.array_equal(same, T_wc)


def test_each_motion_does_what_its_name_says():
    def last(motion: str, **changes: float) -> np.ndarray:
        return synthetic.trajectory(motion, n=5, **changes)[1][-1]

    assert np.array_equal(last("static"), np.eye(4))
    assert last("x", extent=0.4)[:3, 3] == pytest.approx([0.4, 0.0, 0.0])
    assert last("z", extent=0.4)[:3, 3] == pytest.approx([0.0, 0.0, 0.4])
    turned = last("rotation", angle_deg=20.0)
    assert np.linalg.norm(so3_log(turned[:3, :3])) == pytest.approx(math.radians(20.0))
    assert np.array_equal(turned[:3, 3], np.zeros(3))
    arc = last("arc", angle_deg=30.0, radius=2.0)
    assert arc[0, 3] == pytest.approx(2.0 * math.sin(math.radians(30.0)))  # to the right
    assert arc[:3, 3] + 2.0 * arc[:3, 2] == pytest.approx([0.0, 0.0, 2.0])  # faces the point


def test_handheld_stays_within_its_bounds():
    _, T_wc = synthetic.trajectory("handheld", n=600, extent=0.3, angle_deg=10.0, seed=1)
    xi = np.array([se3_log(T) for T in T_wc])
    spread = np.ptp(xi, axis=0)
    assert (spread[:3] > 0.05).all()
    assert (spread[:3] <= 0.3 + 1e-9).all()
    assert (spread[3:] <= math.radians(10.0) + 1e-9).all()
    other = synthetic.trajectory("handheld", n=600, seed=2)[1]
    assert not np.array_equal(other, T_wc)


def test_frames_follow_the_path():
    _, T_wc = synthetic.trajectory("arc", n=3)
    noisy = SensorOptions(read_noise=1.0)
    scene = synthetic.room(seed=2)
    frames = list(synthetic.render_sequence(scene, CAMERA, T_wc, **SIZE, sensor=noisy, seed=5))
    assert len(frames) == 3
    for i, frame in enumerate(frames):
        T_cw = se3_inverse(T_wc[i])
        alone = synthetic.render(scene, CAMERA, T_cw, **SIZE, sensor=noisy, seed=5, index=i)
        assert np.array_equal(frame.truth.image, alone.image)
        assert np.array_equal(frame.T_wc, T_wc[i])
        depth = synthetic.sense_depth(alone, CAMERA, seed=5, index=i)
        assert np.array_equal(frame.depth, depth, equal_nan=True)
    assert not np.array_equal(frames[0].truth.image, frames[1].truth.image)


def test_blur_and_shutter_follow_the_path():
    _, T_wc = synthetic.trajectory("x", n=4, extent=0.3)
    options = RenderOptions(exposure_time=1.0, readout_time=0.5, antialiasing="none")
    scene = synthetic.room()
    frames = list(synthetic.render_sequence(scene, CAMERA, T_wc, **SIZE, options=options))
    motion = [-0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
    for i in (0, 2, 3):
        alone = synthetic.render(
            scene, CAMERA, se3_inverse(T_wc[i]), **SIZE, options=options, motion=motion
        )
        assert np.abs(frames[i].truth.irradiance - alone.irradiance).max() < 1e-6
    (single,) = synthetic.render_sequence(scene, CAMERA, T_wc[:1], **SIZE, options=options)
    assert single.truth.valid.all()


def test_each_frame_may_have_a_sensor_of_its_own():
    _, T_wc = synthetic.trajectory("static", n=2)
    sensors = [SensorOptions(format="float32", exposure=e) for e in (1.0, 1.5)]
    scene = synthetic.room()
    dark, bright = synthetic.render_sequence(scene, CAMERA, T_wc, **SIZE, sensor=sensors)
    assert np.allclose(bright.truth.image, 1.5 * dark.truth.image)
    with pytest.raises(ShapeError, match="sensor"):
        next(synthetic.render_sequence(scene, CAMERA, T_wc, **SIZE, sensor=sensors[:1]))


def test_refusals():
    for changes in ({"n": 0}, {"extent": np.nan}, {"radius": 0.0}, {"fps": -1.0}):
        with pytest.raises(OptionsError, match=next(iter(changes))):
            synthetic.trajectory("x", **changes)
    with pytest.raises(OptionsError, match="static, rotation"):
        synthetic.trajectory("sideways")
    with pytest.raises(ShapeError, match="start"):
        synthetic.trajectory("x", start=np.eye(3))
    with pytest.raises(ShapeError, match="T_wc"):
        next(synthetic.render_sequence(synthetic.room(), CAMERA, np.eye(4), **SIZE))
