"""A second, independent evaluator of the BAL cost in plain NumPy, without any raylign code."""

import numpy as np


def rotation_matrices(omega: np.ndarray) -> np.ndarray:
    """Rodrigues' formula for (C, 3) rotation vectors -> (C, 3, 3)."""
    theta = np.linalg.norm(omega, axis=1)
    safe = np.where(theta > 0.0, theta, 1.0)
    k = omega / safe[:, None]
    K = np.zeros((len(omega), 3, 3))
    K[:, 0, 1], K[:, 0, 2] = -k[:, 2], k[:, 1]
    K[:, 1, 0], K[:, 1, 2] = k[:, 2], -k[:, 0]
    K[:, 2, 0], K[:, 2, 1] = -k[:, 1], k[:, 0]
    sin, one_minus_cos = np.sin(theta), 2.0 * np.sin(theta / 2.0) ** 2
    return np.eye(3) + sin[:, None, None] * K + one_minus_cos[:, None, None] * (K @ K)


def residuals(problem) -> np.ndarray:
    """(N, 2) predicted − observed."""
    R = rotation_matrices(problem.cameras[:, :3])[problem.camera_index]
    camera = problem.cameras[problem.camera_index]
    P = np.einsum("nij,nj->ni", R, problem.points[problem.point_index]) + camera[:, 3:6]
    p = -P[:, :2] / P[:, 2:]
    r2 = np.sum(p * p, axis=1, keepdims=True)
    f, k1, k2 = camera[:, 6:7], camera[:, 7:8], camera[:, 8:9]
    return f * (1.0 + k1 * r2 + k2 * r2 * r2) * p - problem.observations


def cost(problem) -> float:
    """½ Σ ‖r‖²."""
    return 0.5 * float(np.sum(residuals(problem) ** 2))
