"""Files in and out: bundle adjustment problems, image sequences, poses, patches, logs.

Every malformed input is one `raylign.FormatError`.
"""

from raylign.io.bal import read_bal, write_bal
from raylign.io.calibration import read_calibration
from raylign.io.duplicates import resolve_duplicates
from raylign.io.icl_nuim import read_icl_nuim
from raylign.io.image_folder import read_image_folder
from raylign.io.image_list import list_images, read_image
from raylign.io.json_lines import JsonLinesWriter, read_json_lines
from raylign.io.npz import read_npz, write_npz
from raylign.io.opening import SEQUENCE_FORMATS, open_sequence
from raylign.io.patch_points import PatchPoints, read_patch_points, write_patch_points
from raylign.io.ply import PlySummary, write_ply, write_ply_points
from raylign.io.poses import StampedPoses, read_poses, write_poses
from raylign.io.sequence import Calibration, RgbdFrame, RgbdSequence, SequenceReport
from raylign.io.seven_scenes import read_seven_scenes
from raylign.io.stereo import read_euroc, read_stereo_pair
from raylign.io.trajectory import (
    read_kitti_poses,
    read_tum_trajectory,
    write_kitti_poses,
    write_tum_trajectory,
)
from raylign.io.tum import read_tum_rgbd
from raylign.io.tum_writer import TumSequenceWriter

__all__ = [
    "SEQUENCE_FORMATS",
    "Calibration",
    "JsonLinesWriter",
    "PatchPoints",
    "PlySummary",
    "RgbdFrame",
    "RgbdSequence",
    "SequenceReport",
    "StampedPoses",
    "TumSequenceWriter",
    "list_images",
    "open_sequence",
    "read_bal",
    "read_calibration",
    "read_euroc",
    "read_icl_nuim",
    "read_image",
    "read_image_folder",
    "read_json_lines",
    "read_kitti_poses",
    "read_npz",
    "read_patch_points",
    "read_poses",
    "read_seven_scenes",
    "read_stereo_pair",
    "read_tum_rgbd",
    "read_tum_trajectory",
    "resolve_duplicates",
    "write_bal",
    "write_kitti_poses",
    "write_npz",
    "write_patch_points",
    "write_ply",
    "write_ply_points",
    "write_poses",
    "write_tum_trajectory",
]
