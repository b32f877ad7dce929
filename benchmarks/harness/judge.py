"""The independent judge: NumPy's own reading of a problem file, of its cost, and of a trace.

Every system is judged by this code and by nothing else, because two systems that mean different
costs by the same name have been compared before (half or whole squares, points behind the camera
dropped or kept).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

CHUNK = 1 << 19  # observations at a time: the judge stays small beside what it judges
LEVELS = (0.1, 0.01, 0.001, 0.0001)  # of the decrease from the start to the best cost
STRICT = 1.001  # times the best cost: harder than LEVELS where the start is far away


@dataclass(frozen=True)
class Problem:
    """Arrays of a BAL text file."""

    cameras: np.ndarray  # (C, 9): angle-axis, t, f, k1, k2
    points: np.ndarray  # (P, 3)
    camera_index: np.ndarray  # (N,)
    point_index: np.ndarray  # (N,)
    pixels: np.ndarray  # (N, 2)


def read_problem(path: Path) -> Problem:
    with path.open() as file:
        C, P, N = np.fromfile(file, sep=" ", count=3).astype(int)
        rows = np.fromfile(file, sep=" ", count=4 * N).reshape(N, 4)
        cameras = np.fromfile(file, sep=" ", count=9 * C).reshape(C, 9)
        points = np.fromfile(file, sep=" ", count=3 * P).reshape(P, 3)
    index = rows[:, :2].astype(np.int64)
    return Problem(cameras, points, index[:, 0], index[:, 1], rows[:, 2:].copy())


def read_parameters(path: Path, like: Problem) -> tuple[np.ndarray, np.ndarray]:
    """Cameras and points as a worker left them."""
    values = np.fromfile(path)
    split = like.cameras.size
    return values[:split].reshape(like.cameras.shape), values[split:].reshape(like.points.shape)


def rotate(w: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Rodrigues' formula, row by row."""
    theta = np.linalg.norm(w, axis=1, keepdims=True)
    axis = w / np.where(theta > 0.0, theta, 1.0)
    along = np.sum(axis * X, axis=1, keepdims=True) * axis
    return along + np.cos(theta) * (X - along) + np.sin(theta) * np.cross(axis, X)


def depths(problem: Problem) -> np.ndarray:
    """−P_z of every observation: positive in front of the camera."""
    parameters = problem.cameras[problem.camera_index]
    P = rotate(parameters[:, :3], problem.points[problem.point_index]) + parameters[:, 3:6]
    return -P[:, 2]


def cost(problem: Problem, cameras: np.ndarray, points: np.ndarray) -> float:
    """½ Σ ‖r‖² of the BAL model, whatever lies behind a camera included."""
    total = 0.0
    for first in range(0, len(problem.pixels), CHUNK):
        part = slice(first, first + CHUNK)
        parameters = cameras[problem.camera_index[part]]
        P = rotate(parameters[:, :3], points[problem.point_index[part]]) + parameters[:, 3:6]
        p = -P[:, :2] / P[:, 2:]
        r2 = np.sum(p * p, axis=1)
        f, k1, k2 = parameters[:, 6:].T
        residual = (f * (1.0 + r2 * (k1 + k2 * r2)))[:, None] * p - problem.pixels[part]
        total += 0.5 * float(np.sum(residual * residual))
    return total


def targets(initial: float, best: float) -> list[float]:
    """Costs that leave a LEVELS share of the decrease initial − best undone; last STRICT · best."""
    return [*(best + level * (initial - best) for level in LEVELS), STRICT * best]


def time_to(trace: list[list[float]], target: float) -> float:
    """Seconds since the call until the cost was at most `target`; inf when it never was."""
    return next((seconds for seconds, value in trace if value <= target), float("inf"))


def ns_per_observation_and_iteration(run: dict, num_observations: int) -> float:
    """Mean over all Levenberg-Marquardt iterations, rejected ones included; no preprocessing."""
    iterations = len(run["trace"]) - 1
    if iterations < 1:
        return float("nan")
    seconds = run["trace"][-1][0] - run["trace"][0][0]
    return 1e9 * seconds / iterations / num_observations
