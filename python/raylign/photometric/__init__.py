"""Photometric bundle adjustment: poses and points refined from grey values, without features.

Arrays in, arrays out: images, intrinsics, rough poses and points; each point has a small patch of
grey values, read from one of the images or given. Brightness per image and the law of the noise are
estimated, every point and view has a status, and points held out of the solve say whether the
result is better than the start. docs/guide/photometric.md shows it, docs/theory/photometric.md has
the formulas.

    import raylign.photometric as pba

    problem = pba.Problem(images, K, T_cw, points)
    result = pba.adjust(problem)
    print(result.full_report())
    result.write_ply("points.ply", color="error")
"""

from raylign._core import (
    BrightnessModel,
    BrightnessOptions,
    CovarianceScope,
    CramerRaoBound,
    EdgeStatus,
    LeavingRule,
    LossScope,
    NoiseOptions,
    PatchBorder,
    PatchPattern,
    PatchWarp,
    PhotometricOptions,
    PointStatus,
    VisibilityOptions,
    VisibilityRule,
)
from raylign.photometric._adjust import Preset, adjust, cramer_rao, default_config, preset
from raylign.photometric._problem import Problem
from raylign.photometric._result import PhotometricResult

__all__ = [
    "BrightnessModel",
    "BrightnessOptions",
    "CovarianceScope",
    "CramerRaoBound",
    "EdgeStatus",
    "LeavingRule",
    "LossScope",
    "NoiseOptions",
    "PatchBorder",
    "PatchPattern",
    "PatchWarp",
    "PhotometricOptions",
    "PhotometricResult",
    "PointStatus",
    "Preset",
    "Problem",
    "VisibilityOptions",
    "VisibilityRule",
    "adjust",
    "cramer_rao",
    "default_config",
    "preset",
]
