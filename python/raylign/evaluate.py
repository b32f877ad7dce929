"""How far a reconstruction is from the truth, where the truth is known.

For camera paths over time see `raylign.trajectory.evaluate`.
"""

import numpy as np

from raylign import geometry
from raylign._typing import F64
from raylign.errors import ShapeError
from raylign.scene import BalProblem


def camera_center_errors(problem: BalProblem, truth: BalProblem) -> F64:
    """Return the distance of each camera centre from the truth after similarity alignment.

    A reconstruction from images alone is known up to a similarity; the one that fits the centres
    best in the least-squares sense is removed first (Umeyama, PAMI 1991).

    Args:
        problem: estimated cameras.
        truth: the same cameras, true, in the same order.

    Returns:
        (C,) float64, scene units of `truth`.

    Raises:
        ShapeError: the numbers of cameras differ, or are less than three.
        Error: the centres lie on one line and determine no rotation.
    """
    if problem.num_cameras != truth.num_cameras:
        raise ShapeError(
            f"camera_center_errors: {problem.num_cameras} cameras against {truth.num_cameras}"
        )
    estimated, true = problem.camera_centers(), truth.camera_centers()
    S_te = geometry.umeyama(estimated, true)
    aligned = estimated @ S_te[:3, :3].T + S_te[:3, 3]
    return np.asarray(np.linalg.norm(aligned - true, axis=1))
