"""Scenes as plain arrays: cameras, points, the pixels that tie them, and their statistics.

`BalProblem` keeps the nine numbers per camera and the axes of the file format: angle-axis of R_cw
(rad), t_cw, f (px), k1, k2; the camera looks along −z and v points up:
P = R_cw X + t_cw, p = −P_xy / P_z, (u, v) = f (1 + k1 ‖p‖² + k2 ‖p‖⁴) p.

`BundleProblem` is the general one: poses T_cw as (C, 4, 4) matrices and the parameters of a
`CameraModel`, one row per camera: PINHOLE (fx, fy, cx, cy), RADTAN (the same, then k1, k2, p1, p2,
k3) or BAL. `BundleProblem.from_bal` and `to_bal` convert.

Source: Agarwal et al., Bundle Adjustment in the Large, ECCV 2010; Brown 1971.

Example:
    >>> import raylign
    >>> bal = raylign.synthetic.bal(num_cameras=10, num_points=200, seed=1).problem
    >>> problem = BundleProblem.from_bal(bal, camera_model=CameraModel.RADTAN)
    >>> problem.T_cw.shape, problem.intrinsics.shape
    ((10, 4, 4), (10, 9))
    >>> abs(problem.cost() / bal.cost() - 1.0) < 1e-12
    True
"""

from raylign import _core
from raylign._core import (
    BalProblem,
    BundleProblem,
    CameraModel,
    CountSummary,
    ProblemStatistics,
)

__all__ = [
    "BalProblem",
    "BundleProblem",
    "CameraModel",
    "CountSummary",
    "ProblemStatistics",
    "param_names",
]


def param_names(camera_model: CameraModel) -> list[str]:
    """Names of the columns of `BundleProblem.intrinsics`.

    They are also the coordinates that a `ConstantCoordinate` of kind INTRINSICS may name.

    Example:
        >>> param_names(CameraModel.PINHOLE)
        ['fx', 'fy', 'cx', 'cy']
    """
    return _core.camera_param_names(camera_model)
