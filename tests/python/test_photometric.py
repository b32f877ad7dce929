"""`raylign.photometric.adjust` from Python: what comes back, how it stops, what it leaves."""

import os
import signal

import numpy as np
import pytest

import raylign
from photometric_scene import centres, small_scene
from raylign import io, photometric
from raylign.bundle import BundleConfig, Gauge, LmOptions, Termination
from raylign.photometric import CovarianceScope, PhotometricOptions, PointStatus, adjust

FAST = PhotometricOptions(num_levels=1, max_num_rounds=2)


@pytest.fixture(scope="module")
def scene():
    return small_scene()


@pytest.fixture(scope="module")
def problem(scene):
    return scene.problem()


@pytest.fixture(scope="module")
def result(problem):
    return adjust(problem, options=FAST.replace(covariance=CovarianceScope.ALL))


def test_poses_become_better(scene, result):
    before = np.linalg.norm(centres(scene.T_start) - centres(scene.T_true), axis=1)
    after = np.linalg.norm(centres(result.T_cw) - centres(scene.T_true), axis=1)
    assert result.accepted
    assert after.max() < 0.5 * before.max()
    np.testing.assert_array_equal(result.T_cw[0], scene.T_start[0])  # held, bit by bit
    assert 1.5 < result.sigma < 3.5
    low, high = result.residual_median()
    assert high < low


def test_everything_has_its_shape(problem, result):
    M, N, E = problem.num_images, problem.num_points, len(result.edge_image)
    shapes = {
        "T_cw": (M, 4, 4), "points": (N, 3), "brightness": (M, 2), "intrinsics": (1, 4),
        "point_status": (N,), "edge_status": (E,), "edge_point": (E,), "edge_rms_before": (E,),
        "edge_rms_after": (E,), "point_rms_before": (N,), "point_rms_after": (N,),
        "image_rms_before": (M,), "image_rms_after": (M,), "shift_px": (M,), "hosts": (N,),
        "host_uv": (N, 2), "patches": (N, 16), "normals": (N, 3),
        "pose_covariance": (6 * M, 6 * M), "point_covariances": (N, 3, 3),
    }  # fmt: skip
    for name, shape in shapes.items():
        assert getattr(result, name).shape == shape, name
    assert sum(result.point_counts().values()) == N
    assert sum(result.edge_counts().values()) == E
    assert result.point_counts()["ok"] > 0.8 * N
    assert {"level", "num_points", "sigma", "final_cost"} <= set(result.rounds.dtype.names)
    assert result.problem is problem
    assert "T_cw" in dir(result)
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = result.no_such_name


def test_reports_say_what_happened(result):
    assert "accepted" in repr(result)
    text = result.full_report()
    for words in ("verdict", "points:", "sigma", "gauge", "shift px"):
        assert words in text


def test_input_stays_and_bits_repeat(problem, result):
    again = adjust(problem, options=FAST.replace(lm=LmOptions(num_threads=3)))
    np.testing.assert_array_equal(again.T_cw, result.T_cw)
    np.testing.assert_array_equal(again.points, result.points)


def test_default_gauge_follows_what_is_known(scene, problem):
    assert photometric.default_config(problem).gauge is Gauge.FIRST_CAMERA
    plain = scene.problem(depth_model=None)
    assert photometric.default_config(plain).gauge is Gauge.TWO_CAMERAS
    anchored = scene.problem(pose_covariance=1e-4 * np.eye(6))
    assert photometric.default_config(anchored).gauge is Gauge.FREE


def test_held_cameras_stay(problem):
    config = BundleConfig(gauge=Gauge.FREE, constant_cameras=[0, 2])
    held = adjust(problem, config=config, options=FAST)
    np.testing.assert_array_equal(held.T_cw[[0, 2]], problem.T_cw[[0, 2]])
    assert not np.array_equal(held.T_cw[1], problem.T_cw[1])


def test_callback_stops_and_exceptions_travel(problem):
    rows = []

    def stop(row):
        rows.append(row.iteration)
        return len(rows) < 3

    stopped = adjust(problem, options=FAST, callback=stop)
    assert rows == [0, 1, 2]
    assert stopped.summary.termination is Termination.USER_STOPPED

    def fail(row):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        adjust(problem, options=FAST, callback=fail)


def test_ctrl_c_keeps_the_best_state(problem):
    def interrupt(row):
        if row.iteration == 2:
            os.kill(os.getpid(), signal.SIGINT)

    result = adjust(problem, options=FAST, callback=interrupt)
    assert result.summary.termination is Termination.USER_STOPPED
    assert result.summary.final_cost < result.summary.initial_cost


def test_what_does_not_go_together_is_refused(scene, problem):
    with pytest.raises(raylign.OptionsError, match="presmooth"):
        PhotometricOptions(presmooth=float("nan"))
    patches = np.zeros((problem.num_points, 9), np.float32)
    stored = photometric.Problem(
        scene.images, problem.camera(0), scene.T_start, problem.points, patches=patches
    )
    with pytest.raises(raylign.ShapeError, match="16"):
        adjust(stored)
    away = photometric.Problem(
        scene.images, problem.camera(0), scene.T_start, problem.points - np.array([0, 0, 100.0])
    )
    with pytest.raises(raylign.ShapeError, match="view"):
        adjust(away)


def test_text_files_come_back(result, tmp_path):
    result.write_text(tmp_path / "points.txt", tmp_path / "poses.txt")
    points, patches = io.read_patch_points(tmp_path / "points.txt")
    np.testing.assert_array_equal(points, result.points)
    np.testing.assert_array_equal(patches, result.patches)
    np.testing.assert_allclose(io.read_poses(tmp_path / "poses.txt").T_cw, result.T_cw, atol=1e-14)


def test_point_clouds_in_every_colour(result, problem, tmp_path):
    for color in ("image", "error", "sigma", "status"):
        summary = result.write_ply(tmp_path / f"{color}.ply", color=color)
        assert summary.num_points == problem.num_points
        assert summary.num_cameras == problem.num_images
        assert len(np.unique(result.point_colors(color), axis=0)) > (0 if color == "status" else 30)
    assert result.write_ply(tmp_path / "a.ply", cameras=False, start=True).num_cameras == 0
    with pytest.raises(raylign.OptionsError, match="'depth'"):
        result.write_ply(tmp_path / "b.ply", color="depth")
    grey = result.point_colors("image")
    host, uv = result.hosts[5], np.rint(result.host_uv[5]).astype(int)
    shown = problem.image(host)[uv[1], uv[0]]
    assert abs(float(grey[5, 0]) - shown) < 40  # the point has moved by part of a pixel


def test_sigma_needs_covariances(problem):
    quick = adjust(problem, options=FAST.replace(covariance=CovarianceScope.NONE))
    assert quick.point_covariances.shape[0] == 0
    with pytest.raises(raylign.OptionsError, match="CovarianceScope"):
        quick.point_colors("sigma")


def test_covariances_are_covariances(result):
    free = result.pose_covariance[6:, 6:]
    assert not result.pose_covariance[:6].any()
    np.testing.assert_allclose(free, free.T, rtol=1e-9)
    assert (np.linalg.eigvalsh(free) > 0).all()
    assert np.sqrt(free.diagonal()).max() < 0.01
    ok = result.point_status == PointStatus.OK.value
    assert np.isfinite(result.point_covariances[ok]).all()


def test_the_bound_is_what_covariances_come_near(scene, problem):
    """Bounds grow with the noise; what a solve claims is of their size."""
    truth, config = scene.truth_problem(), BundleConfig(gauge=Gauge.TWO_CAMERAS)
    one, two = (photometric.cramer_rao(truth, sigma=s, config=config) for s in (1.0, 2.0))
    np.testing.assert_allclose(two.pose_covariance, 4.0 * one.pose_covariance, rtol=1e-6)
    assert two.center_covariances.shape == (3, 3, 3)
    assert two.free_directions == 0
    noisy = photometric.cramer_rao(
        truth, sigma=2.0, config=config, is_rounded=True, has_noisy_patches=True
    )
    free = np.flatnonzero(two.pose_covariance.diagonal())
    assert len(free) == 12
    bound = np.sqrt(noisy.pose_covariance.diagonal()[free])
    assert (bound > np.sqrt(two.pose_covariance.diagonal()[free])).all()
    claimed = adjust(scene.problem(depth_model=None), config=config, options=FAST).pose_covariance
    ratio = np.sqrt(claimed.diagonal()[free]) / bound
    assert ((ratio > 0.5) & (ratio < 2.0)).all()
    with pytest.raises(raylign.OptionsError, match="sigma"):
        photometric.cramer_rao(truth, sigma=0.0)
