"""Arrays of a photometric problem, checked and converted."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from raylign import geometry, io
from raylign._core import PatchPattern
from raylign._typing import F32, F64, I32, AnyArray
from raylign.errors import OptionsError, ShapeError
from raylign.photometric._images import Corrections, as_f64

_QUATERNION_TOLERANCE = 1e-2


def poses_of(T_cw: npt.ArrayLike, convention: str) -> F64:
    """(M, 4, 4) T_cw of matrices or TUM rows in either direction.

    Raises:
        ShapeError: another shape, or a quaternion that is none.
        OptionsError: `convention` is neither "cw" nor "wc".
    """
    if convention not in ("cw", "wc"):
        raise OptionsError(f"convention must be 'cw' or 'wc', got {convention!r}")
    if np.ndim(T_cw) == 2:
        rows = as_f64(T_cw, "T_cw", (None, 7))
        norms = np.linalg.norm(rows[:, 3:], axis=1)
        bad = np.flatnonzero(~(np.abs(norms - 1.0) <= _QUATERNION_TOLERANCE))
        if len(bad):
            row = int(bad[0])
            raise ShapeError(f"T_cw[{row}]: the quaternion's norm is {norms[row]:g}, expected 1")
        poses = io.poses.poses_from_tum(rows)
    else:
        poses = as_f64(T_cw, "T_cw", (None, 4, 4))
    if convention == "cw":
        return poses
    if not np.isfinite(poses).all():
        raise ShapeError("T_cw holds a number that is not finite")
    return np.ascontiguousarray(geometry.se3_inverse(poses))


def image_list(images: Any) -> list[Any]:
    """The images as a list."""
    if isinstance(images, str) or hasattr(images, "__fspath__"):
        raise ShapeError("images must be a list of arrays or paths; io.list_images lists a folder")
    sources = list(images)
    if not sources:
        raise ShapeError("images is empty")
    return sources


def corrections_of(
    response: npt.ArrayLike | None,
    vignette: AnyArray | Sequence[AnyArray] | None,
    exposure: npt.ArrayLike | None,
    saturation: tuple[float, float],
    num_images: int,
) -> Corrections:
    """What `Problem` was told about the sensor."""
    low, high = saturation
    if not low < high:
        raise OptionsError(f"saturation must be (low, high), got {saturation}")
    lut = None if response is None else as_f64(response, "response", (256,))
    if lut is not None and not (np.diff(lut) >= 0).all():
        raise OptionsError("response must not decrease")
    planes = None
    if vignette is not None:
        listed = [vignette] if np.ndim(vignette) == 2 else list(vignette)
        planes = [np.asarray(plane, np.float32) for plane in listed]
        if len(planes) not in (1, num_images):
            raise ShapeError(f"there are {num_images} images but {len(planes)} vignettes")
    times = None if exposure is None else as_f64(exposure, "exposure", (num_images,))
    if times is not None and not (np.isfinite(times) & (times > 0)).all():
        raise OptionsError(f"exposure must be finite and > 0, got {times.tolist()}")
    return Corrections(lut, planes, times, (float(low), float(high)))


def optional(value: npt.ArrayLike | None, name: str, shape: tuple[int, ...]) -> F64 | None:
    """float64 of exactly that shape, or None."""
    return None if value is None else as_f64(value, name, shape)


def patches_by_column(
    patches: npt.ArrayLike | None, num_points: int, order: str, pattern: PatchPattern | str | None
) -> F32 | None:
    """(N, n) float32 by columns, or None; n is the pattern's, where that is known."""
    if order not in ("column", "row"):
        raise OptionsError(f"patch_order must be 'column' or 'row', got {order!r}")
    if patches is None:
        return None
    if isinstance(pattern, str):
        pattern = PatchPattern.parse(pattern)
    size = None if pattern is None else pattern.size
    values = as_f64(patches, "patches", (num_points, size)).astype(np.float32)
    if order == "row":
        side = math.isqrt(values.shape[1])
        if side * side != values.shape[1]:
            raise OptionsError(f"patch_order='row' needs square patches, got {values.shape[1]}")
        values = values.reshape(-1, side, side).transpose(0, 2, 1).reshape(-1, side * side)
    return np.ascontiguousarray(values)


def hosts_of(host: npt.ArrayLike | str | None, num_points: int, has_patches: bool) -> I32 | None:
    """(N,) int32, or None: to be found."""
    if host is None:
        return None
    if isinstance(host, str):
        if host != "auto":
            raise OptionsError(f"host must be 'auto' or (N,) image indices, got {host!r}")
        if has_patches:
            raise OptionsError("host='auto' reads patches from the images: leave out patches")
        return None
    array = np.asarray(host)
    if array.shape != (num_points,) or array.dtype.kind not in "iu":
        found = f"{array.dtype} {array.shape}"
        raise ShapeError(f"host must be integers of shape ({num_points},), got {found}")
    return np.ascontiguousarray(array, np.int32)


def covariances_of(value: npt.ArrayLike | None, name: str, count: int, size: int) -> F64 | None:
    """(count, size, size), one for all repeated, or None."""
    if value is None:
        return None
    if np.ndim(value) == 2:
        shared = as_f64(value, name, (size, size))
        return np.ascontiguousarray(np.broadcast_to(shared, (count, size, size)))
    return as_f64(value, name, (count, size, size))


def tracks_of(
    tracks: npt.ArrayLike | None, num_images: int, num_points: int
) -> tuple[I32 | None, I32 | None]:
    """Images and points of the pairs, or None, None."""
    if tracks is None:
        return None, None
    array = np.asarray(tracks)
    if array.dtype == np.bool_ and array.shape == (num_images, num_points):
        image, point = np.nonzero(array)
    elif array.dtype.kind in "iu" and array.ndim == 2 and array.shape[1] == 2:
        image, point = array[:, 0], array[:, 1]
    else:
        raise ShapeError(
            f"tracks must be bool ({num_images}, {num_points}) or integers (K, 2), got "
            f"{array.dtype} {array.shape}"
        )
    return np.ascontiguousarray(image, np.int32), np.ascontiguousarray(point, np.int32)
