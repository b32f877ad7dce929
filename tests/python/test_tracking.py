"""Direct tracking through the Python façade."""

import numpy as np
import pytest

import raylign
from raylign.tracking import (
    AlignmentStatus,
    Frame,
    Keyframe,
    KeyframeOptions,
    MotionGroup,
    Tracker,
    TrackingOptions,
    align,
)

CAMERA = raylign.camera.PinholeCamera(fx=130.0, fy=130.0, cx=79.5, cy=59.5)
XI = np.array([0.02, -0.01, 0.015, 0.01, 0.02, -0.005])


def plane_view(T_th: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exact image and inverse depth of a slanted textured plane, (120, 160) float32."""
    v, u = np.mgrid[0:120, 0:160]
    rays = np.stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)])
    T_ht = np.linalg.inv(T_th)
    rays = np.einsum("ij,jvu->ivu", T_ht[:3, :3], rays)
    normal = np.array([-0.3, 0.1, 1.0])
    depth = (2.0 - normal @ T_ht[:3, 3]) / np.einsum("i,ivu->vu", normal, rays)
    x, y, _ = T_ht[:3, 3, None, None] + depth * rays
    grey = 128 + 35 * np.sin(10 * x) + 30 * np.cos(9 * y) + 25 * np.sin(6 * x + 8 * y)
    return grey.astype(np.float32), (1 / depth).astype(np.float32)


@pytest.fixture(scope="module")
def keyframe() -> Keyframe:
    image, D = plane_view(np.eye(4))
    return Keyframe(image, CAMERA, inverse_depth=D, variance=1e-6)


def error(T: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    xi = raylign.geometry.se3_log(T @ np.linalg.inv(truth))
    return float(np.linalg.norm(xi[:3])), float(np.linalg.norm(xi[3:]))


@pytest.mark.parametrize("with_depth", [False, True])
def test_align_finds_the_motion(keyframe: Keyframe, with_depth: bool) -> None:
    truth = raylign.geometry.se3_exp(XI)
    image, D = plane_view(truth)
    depth = {"inverse_depth": D, "variance": 1e-6} if with_depth else {}
    result = align(keyframe, image, options=TrackingOptions(finest_level=0), **depth)
    assert result.status is AlignmentStatus.OK
    t, R = error(result.T_th, truth)
    assert t < 2e-4
    assert R < 1e-4
    assert result.covariance.shape == (6, 6)


def test_tracker_starts_where_it_ended(keyframe: Keyframe) -> None:
    truth = raylign.geometry.se3_exp(XI)
    frame = Frame(plane_view(truth)[0], CAMERA)
    tracker = Tracker(options=TrackingOptions(finest_level=0))
    with pytest.raises(raylign.OptionsError, match="keyframe must be set"):
        tracker.track(frame)
    tracker.set_keyframe(keyframe)
    first = tracker.track(frame)
    second = tracker.track(frame)
    assert first.ok
    assert second.ok
    assert second.levels[0].num_evaluations < first.levels[0].num_evaluations
    assert error(second.T_th, truth)[0] < 2e-4


def test_maps_are_asked_for(keyframe: Keyframe) -> None:
    image, _ = plane_view(raylign.geometry.se3_exp(XI))
    options = TrackingOptions(finest_level=0)
    assert align(keyframe, image, options=options).maps is None
    maps = align(keyframe, image, options=options, maps=True).maps
    assert maps is not None
    assert maps.mask.dtype == bool
    assert maps.mask.sum() > 5000
    n = maps.residual / maps.sigma
    np.testing.assert_allclose(maps.normalised_residual[maps.mask], n[maps.mask], rtol=1e-5)
    assert np.isnan(maps.residual[~maps.mask]).all()


def test_points_obey_the_budget() -> None:
    image, D = plane_view(np.eye(4))
    options = KeyframeOptions(max_points=500, min_gradient=2.0)
    keyframe = Keyframe(image, CAMERA, inverse_depth=D, variance=1e-6, options=options)
    points = keyframe.points(level=0)
    assert 450 <= len(points) <= 500
    left = (points[:, 0] < 80).mean()
    assert 0.4 < left < 0.6
    np.testing.assert_array_equal(
        points[:, 4], image[points[:, 1].astype(int), points[:, 0].astype(int)]
    )


def test_bad_input_is_refused(keyframe: Keyframe) -> None:
    image, D = plane_view(np.eye(4))
    with pytest.raises(raylign.ShapeError, match="inverse_depth must be a float32"):
        Keyframe(image, CAMERA, inverse_depth=D.astype(np.float64), variance=1e-6)
    with pytest.raises(raylign.ShapeError, match="image's size"):
        Keyframe(image, CAMERA, inverse_depth=D[:60], variance=1e-6)
    with pytest.raises(raylign.OptionsError, match="variance must be given"):
        Frame(image, CAMERA, inverse_depth=D)
    with pytest.raises(raylign.ShapeError, match="needs a frame with inverse depth"):
        Keyframe.from_frame(Frame(image, CAMERA))
    with pytest.raises(raylign.OptionsError, match="rigid motion"):
        align(keyframe, image, T_init=np.diag([2.0, 2.0, 2.0, 1.0]))
    with pytest.raises(raylign.OptionsError, match="SIM3 needs a target with depth"):
        align(keyframe, image, options=TrackingOptions(motion=MotionGroup.SIM3))
