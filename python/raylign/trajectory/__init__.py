"""Stamped camera paths: association in time, alignment, and errors against a truth.

Poses are `T_wc` (camera to world), as TUM and KITTI files hold them; stamps are in s, positions in
the unit of the file (m). `evaluate` does what `raylign evaluate` prints; `match`, `align`, `ate`,
`rpe` and `segment_errors` are its steps. The numbers agree with evo and the TUM and KITTI tools
where these define them. For bundle adjustment problems see `raylign.evaluate`; files are read and
written by `raylign.io`.
"""

from raylign.trajectory._association import associate, estimate_time_offset, match
from raylign.trajectory._evaluation import Evaluation, evaluate
from raylign.trajectory._metrics import (
    KITTI_LENGTHS_M,
    AbsoluteError,
    Alignment,
    ErrorStatistics,
    RelativeError,
    SegmentError,
    align,
    ate,
    coverage,
    rpe,
    segment_errors,
    short_lengths,
)
from raylign.trajectory._poses import Trajectory

__all__ = [
    "KITTI_LENGTHS_M",
    "AbsoluteError",
    "Alignment",
    "ErrorStatistics",
    "Evaluation",
    "RelativeError",
    "SegmentError",
    "Trajectory",
    "align",
    "associate",
    "ate",
    "coverage",
    "estimate_time_offset",
    "evaluate",
    "match",
    "rpe",
    "segment_errors",
    "short_lengths",
]
