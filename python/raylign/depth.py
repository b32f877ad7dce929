"""Depth sensors: from depth images to inverse depth and its variance.

A tracker reads inverse depth D = 1/Z, because its error is what a camera's error makes of a point,
and the variance V of D. Four laws of noise cover the usual sensors:

    >>> import numpy as np
    >>> kinect = DepthModel()
    >>> kinect.inverse_depth_sigma([1.0, 2.0, 4.0]).round(5).tolist()
    [0.00188, 0.00152, 0.00161]
    >>> stereo = DepthModel(noise=DepthNoise.DISPARITY, focal_baseline=718.9 * 0.537)
    >>> D, V = inverse_depth(np.full((4, 6), 2.0, np.float32), model=kinect)
    >>> float(D[0, 0]), D.dtype, V.shape
    (0.5, dtype('float32'), (4, 6))
"""

import numpy as np

from raylign import _core
from raylign._core import DepthModel, DepthNoise
from raylign._typing import F32, AnyArray

__all__ = ["DepthModel", "DepthNoise", "from_disparity", "inverse_depth"]


def inverse_depth(
    depth: AnyArray, *, model: DepthModel | None = None, depth_scale: float = 1000.0
) -> tuple[F32, F32]:
    """Inverse depth of a depth image and its variance.

    Args:
        depth: (H, W) float32 in m, or uint16 in units of 1/depth_scale m; rows may be apart (a
            crop is read in place). 0, 65535 (uint16), NaN and infinity mean: no depth.
        model: noise, range and treatment of depth steps; default: a Kinect.
        depth_scale: units per metre of uint16 images, > 0: 1000 for millimetres, 5000 for TUM.

    Returns:
        D, V: (H, W) float32, 1/m and 1/m²; both 0 where there is no trusted depth.

    Raises:
        ShapeError: `depth` is of another dtype or shape.
        OptionsError: a field of `model` or `depth_scale` is out of range.

    Note: releases the GIL.

    Source: Nguyen, Izadi & Lovell, 3DIMPVT 2012 (Kinect); variance of 1/Z to first order.
    """
    return _core.inverse_depth(depth, model=model or DepthModel(), depth_scale=depth_scale)


def from_disparity(disparity: AnyArray, *, focal_baseline: float) -> F32:
    """Depth of rectified stereo, Z = f b / d.

    Args:
        disparity: (H, W) real, px; <= 0 and not finite mean: no depth.
        focal_baseline: f · b in px · m, > 0.

    Returns:
        (H, W) float32 in m, 0 where there is no depth.

    Example:
        >>> from_disparity(np.array([[0.0, 10.0]]), focal_baseline=50.0).tolist()
        [[0.0, 5.0]]
    """
    d = np.asarray(disparity, np.float32)
    known = np.isfinite(d) & (d > 0)
    return np.divide(np.float32(focal_baseline), d, out=np.zeros_like(d), where=known)
