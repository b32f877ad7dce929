"""Photometric bundle adjustment of recorded images: the right is accepted, the wrong is not."""

from pathlib import Path

import numpy as np
import pytest

from raylign import io, odometry, photometric
from raylign.geometry import se3_exp, se3_inverse
from raylign.photometric import PatchPattern, PhotometricOptions, PointStatus

pytestmark = [pytest.mark.data, pytest.mark.slow]

K = (277.34, 291.402, 312.234, 239.777)  # of the exercise


def hosted(folder: Path, T_cw: np.ndarray, points: np.ndarray, **known) -> photometric.Problem:
    """The exercise's images and points, patches read from the images."""
    return photometric.Problem([folder / f"{i}.png" for i in range(7)], K, T_cw, points, **known)


def shaken(T_cw: np.ndarray, *, degrees: float, metres: float, seed: int) -> np.ndarray:
    """All cameras but the first turned and moved, each in its own direction."""
    directions = np.random.default_rng(seed).normal(size=(len(T_cw), 2, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    xi = np.concatenate([metres * directions[:, 0], np.radians(degrees) * directions[:, 1]], axis=1)
    xi[0] = 0.0
    return se3_exp(xi) @ T_cw


@pytest.fixture(scope="module")
def exercise(shared_data: Path) -> tuple[Path, np.ndarray, np.ndarray]:
    folder = shared_data / "direct_ba"
    points, _ = io.read_patch_points(folder / "points.txt")
    return folder, io.read_poses(folder / "poses.txt")[1], points[::6]


@pytest.mark.parametrize("pattern", ["4x4", "spread8"])
def test_patches_read_from_the_images_are_accepted(exercise, pattern):
    options = PhotometricOptions(pattern=PatchPattern.parse(pattern), covariance="none")
    result = photometric.adjust(hosted(*exercise), options=options)
    assert result.accepted, result.reason


def test_far_starts_come_back_or_are_refused(exercise):
    folder, T_cw, points = exercise
    options = PhotometricOptions(covariance="none")
    found = photometric.adjust(hosted(folder, T_cw, points), options=options)
    verdicts = []
    for degrees, metres in ((1.0, 0.02), (25.0, 0.6)):  # 8 and 280 px
        start = shaken(found.T_cw, degrees=degrees, metres=metres, seed=5)
        problem = hosted(folder, start, found.points, host=found.hosts, host_uv=found.host_uv)
        result = photometric.adjust(problem, options=options)
        verdicts.append(result.accepted)
        if result.accepted:
            assert np.median(far_px(problem, result, found)) < 0.5, degrees
    assert verdicts == [True, False]


def far_px(problem: photometric.Problem, result, expected) -> np.ndarray:
    """Distances between the projections of points that both results use; not in the first image."""
    used = [r.point_status == PointStatus.OK.value for r in (result, expected)]
    parts = []
    for i in range(1, problem.num_images):
        a, _ = problem.project(i, T_cw=result.T_cw, points=result.points)
        b, _ = problem.project(i, T_cw=expected.T_cw, points=expected.points)
        parts.append(np.linalg.norm(a - b, axis=1)[used[0] & used[1]])
    return np.concatenate(parts)


def test_odometry_of_a_depth_camera_is_accepted(shared_data):
    sequence = io.open_sequence(shared_data / "seven_scenes_250")
    frames = [sequence[i] for i in range(61)]
    run = odometry.run(frames, sequence.camera)
    used = range(0, 61, 6)
    T_cw = se3_inverse(np.array([run.results[i].T_wc for i in used]))
    problem = photometric.Problem.from_depth(
        [frames[i].image for i in used],
        [frames[i].depth for i in used],
        sequence.camera,
        T_cw,
        500,
    )
    result = photometric.adjust(problem, options=PhotometricOptions(covariance="none"))
    assert result.accepted, result.reason
