"""Operations on images held in NumPy arrays, `image[v, u]`: (H, W) or (H, W, 3)."""

from raylign import _core
from raylign._core import Interpolation
from raylign._typing import F32, AnyArray

__all__ = ["Interpolation", "remap"]


def remap(
    image: AnyArray,
    map_x: F32,
    map_y: F32,
    *,
    interpolation: Interpolation = Interpolation.LINEAR,
) -> AnyArray:
    """Resample an image: result[v, u] = image at (map_x[v, u], map_y[v, u]).

    0 outside the image and where a map is not finite. OpenCV's remap of the library the
    extension is linked to; it rounds coordinates to 1/32 px for LINEAR and CUBIC.

    Args:
        image: (H, W) or (H, W, 3), uint8, uint16 or float32, sides in [1, 32766]; rows may be
            apart (a crop is read in place), pixels within a row may not.
        map_x: (H', W') float32, C order, columns in px, sides in [1, 32766].
        map_y: (H', W') float32, C order, rows in px.
        interpolation: how to read between pixels.

    Returns:
        (H', W') or (H', W', 3) array of the dtype of `image`.

    Raises:
        ShapeError: shapes, dtypes or memory order are not as above.

    Note: releases the GIL.

    Example:
        >>> import numpy as np
        >>> image = np.arange(12, dtype=np.float32).reshape(3, 4)
        >>> x, y = np.full((1, 1), 1.5, np.float32), np.full((1, 1), 2.0, np.float32)
        >>> remap(image, x, y)
        array([[9.5]], dtype=float32)
    """
    return _core.remap(image, map_x, map_y, interpolation=interpolation)
