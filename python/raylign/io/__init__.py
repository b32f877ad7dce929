"""Files in and out: bundle adjustment problems, image sequences, trajectories, logs.

Every malformed input is one `raylign.FormatError`.
"""

from raylign.io.bal import read_bal, write_bal
from raylign.io.duplicates import resolve_duplicates
from raylign.io.json_lines import JsonLinesWriter, read_json_lines
from raylign.io.npz import read_npz, write_npz
from raylign.io.ply import PlySummary, write_ply
from raylign.io.sequence import Calibration, RgbdFrame, RgbdSequence, SequenceReport
from raylign.io.seven_scenes import read_seven_scenes
from raylign.io.trajectory import (
    read_kitti_poses,
    read_tum_trajectory,
    write_kitti_poses,
    write_tum_trajectory,
)
from raylign.io.tum import read_tum_rgbd

__all__ = [
    "Calibration",
    "JsonLinesWriter",
    "PlySummary",
    "RgbdFrame",
    "RgbdSequence",
    "SequenceReport",
    "read_bal",
    "read_json_lines",
    "read_kitti_poses",
    "read_npz",
    "read_seven_scenes",
    "read_tum_rgbd",
    "read_tum_trajectory",
    "resolve_duplicates",
    "write_bal",
    "write_kitti_poses",
    "write_npz",
    "write_ply",
    "write_tum_trajectory",
]
