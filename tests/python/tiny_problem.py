"""A problem that fits into a test: four cameras, twenty points."""

import numpy as np

from raylign.scene import BalProblem


def make_tiny_problem(seed: int = 7) -> BalProblem:
    """Build 4 cameras on an arc, 20 points about the origin, and their pixels with 0.5 px noise.

    Written without raylign's geometry, so that it can serve as an oracle.
    """
    rng = np.random.default_rng(seed)
    num_cameras, num_points = 4, 20
    points = rng.uniform(-1.0, 1.0, (num_points, 3))
    angles = np.linspace(-0.4, 0.4, num_cameras)
    cameras = np.zeros((num_cameras, 9))
    cameras[:, 1] = angles
    cameras[:, 3:6] = rng.normal([0.0, 0.0, -6.0], 0.05, (num_cameras, 3))
    cameras[:, 6:] = [500.0, -1e-2, 1e-3]
    camera_index, point_index = np.divmod(np.arange(num_cameras * num_points), num_points)
    observations = np.empty((num_cameras * num_points, 2))
    for i, (c, p) in enumerate(zip(camera_index, point_index, strict=True)):
        cos, sin = np.cos(angles[c]), np.sin(angles[c])
        R_cw = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
        P = R_cw @ points[p] + cameras[c, 3:6]
        xy = -P[:2] / P[2]
        r2 = xy @ xy
        f, k1, k2 = cameras[c, 6:]
        observations[i] = f * (1.0 + k1 * r2 + k2 * r2 * r2) * xy
    observations += rng.normal(0.0, 0.5, observations.shape)
    return BalProblem(
        cameras,
        points,
        camera_index.astype(np.int32),
        point_index.astype(np.int32),
        observations,
    )
