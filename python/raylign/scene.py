"""Scenes as plain arrays: the Bundle-Adjustment-in-the-Large problem and its statistics.

`BalProblem` keeps the nine numbers per camera and the axes of the file format: angle-axis of R_cw
(rad), t_cw, f (px), k1, k2; the camera looks along −z and v points up:
P = R_cw X + t_cw, p = −P_xy / P_z, (u, v) = f (1 + k1 ‖p‖² + k2 ‖p‖⁴) p.

Source: Agarwal et al., Bundle Adjustment in the Large, ECCV 2010.
"""

from raylign._core import BalProblem, CountSummary, ProblemStatistics

__all__ = ["BalProblem", "CountSummary", "ProblemStatistics"]
