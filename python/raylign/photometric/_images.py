"""Images made ready: read, turned grey, corrected for response, vignette, exposure, distortion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from raylign import io
from raylign._typing import F32, F64, U8, AnyArray
from raylign.camera import PinholeCamera, RadtanCamera, without_distortion
from raylign.errors import OptionsError, ShapeError
from raylign.image import ColorOrder, Interpolation, Undistorter, to_grey

Camera = PinholeCamera | RadtanCamera

_MIN_VIGNETTE = 0.05  # a darker pixel is noise, however much it is amplified


@dataclass(frozen=True)
class Corrections:
    """What turns pixels into irradiance: I = lut(pixel) / vignette / exposure.

    Attributes:
        response: (256,) grey value of the irradiance for each raw grey value, or None.
        vignette: (H, W) share of the light that arrives, for all images or one each, or None.
        exposure: (M,) exposure times in any unit, or None.
        saturation: raw grey values outside do not count when anything is corrected.
    """

    response: F64 | None
    vignette: list[F32] | None
    exposure: F64 | None
    saturation: tuple[float, float]

    @property
    def active(self) -> bool:
        """Grey values are no longer those of the sensor."""
        return not (self.response is None and self.vignette is None and self.exposure is None)


@dataclass(frozen=True)
class Prepared:
    """What a problem keeps of its images.

    Attributes:
        grey: (H, W) float32 each, 0..255 before corrections.
        colors: (H, W, 3) RGB uint8 each, undistorted, or None for grey images.
        masks: (H, W) uint8 each, 0 does not count, or None.
        cameras: pinholes of the undistorted images, one for all or one each.
    """

    grey: list[F32]
    colors: list[U8 | None]
    masks: list[U8 | None]
    cameras: list[PinholeCamera]


def prepare(
    images: Sequence[Any],
    cameras: list[Camera],
    *,
    masks: Sequence[Any] | None,
    corrections: Corrections,
    color_order: ColorOrder,
) -> Prepared:
    """Read and correct every image.

    Raises:
        FormatError: a file cannot be read.
        ShapeError: an image is none, or a mask or vignette has another size.
    """
    undistorters: dict[tuple[Camera, int, int], Undistorter] = {}
    result = Prepared([], [], [], [])
    for i, source in enumerate(images):
        pixels = load_pixels(source, i)
        camera = cameras[i if len(cameras) > 1 else 0]
        grey = _named(f"images[{i}]", lambda p=pixels: to_grey(p, color_order=color_order))
        mask = _mask(None if masks is None else masks[i], grey.shape, i)
        if corrections.active:
            grey, mask = _correct(grey, mask, corrections, i)
        color = _rgb(pixels, color_order)
        if isinstance(camera, RadtanCamera):
            key = (camera, grey.shape[1], grey.shape[0])
            if key not in undistorters:
                undistorters[key] = Undistorter(camera, width=key[1], height=key[2])
            grey, color, mask = _undistort(undistorters[key], grey, color, mask)
        result.grey.append(grey)
        result.colors.append(color)
        result.masks.append(mask)
    result.cameras.extend(without_distortion(c) for c in cameras)
    return result


def cameras_of(K: Any, distortion: npt.ArrayLike | None, num_images: int) -> list[Camera]:
    """One camera for all images or one each, from whatever says what they are.

    Raises:
        OptionsError: a matrix is none of a camera, or a number is out of range.
        ShapeError: there are not as many as images.
    """
    if isinstance(K, PinholeCamera | RadtanCamera):
        cameras: list[Camera] = [K]
    elif isinstance(K, Sequence) and K and isinstance(K[0], PinholeCamera | RadtanCamera):
        cameras = list(K)
    else:
        cameras = [PinholeCamera(*row) for row in _intrinsics(K).tolist()]
    if distortion is not None:
        cameras = _distorted(cameras, np.asarray(distortion, np.float64))
    if len(cameras) not in (1, num_images):
        raise ShapeError(f"K holds {len(cameras)} cameras for {num_images} images")
    return cameras


def check_principal_points(cameras: list[PinholeCamera], images: list[F32]) -> None:
    """Refuse calibrations that were made for images of another size.

    Raises:
        OptionsError: a principal point is outside of its image.
    """
    for i, image in enumerate(images):
        camera = cameras[i if len(cameras) > 1 else 0]
        height, width = image.shape
        if not (0.0 <= camera.cx < width and 0.0 <= camera.cy < height):
            raise OptionsError(
                f"images[{i}] is {width} x {height} px, but the principal point of its camera is "
                f"({camera.cx:g}, {camera.cy:g}): K belongs to images of another size"
            )


def load_pixels(source: Any, i: int) -> AnyArray:
    """Image i, an array or a path, as an array.

    Raises:
        FormatError: the file cannot be read.
        ShapeError: it is neither.
    """
    if isinstance(source, np.ndarray):
        return source
    if isinstance(source, str) or hasattr(source, "__fspath__"):
        return io.read_image(source)
    raise ShapeError(f"images[{i}] must be an array or a path, got {type(source).__name__}")


def as_f64(value: npt.ArrayLike, name: str, shape: tuple[int | None, ...]) -> F64:
    """A C-ordered float64 copy of real numbers of that shape; None: any length.

    Raises:
        ShapeError: it has another shape, or no real numbers.
    """
    wanted = "(" + ", ".join("N" if n is None else str(n) for n in shape) + ")"
    try:
        array = np.asarray(value)
    except ValueError as error:  # ragged
        raise ShapeError(f"{name} must be real numbers of shape {wanted}: {error}") from None
    fits = array.ndim == len(shape) and all(
        n in (None, m) for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits or array.dtype.kind not in "fiu":
        found = f"{array.dtype} {array.shape}"
        raise ShapeError(f"{name} must be real numbers of shape {wanted}, got {found}")
    return np.array(array, np.float64, order="C")


def _named(name: str, make: Any) -> Any:
    try:
        return make()
    except ShapeError as error:
        raise ShapeError(f"{name}: {error}") from None


def _mask(source: Any, shape: tuple[int, ...], i: int) -> U8 | None:
    if source is None:
        return None
    mask = np.asarray(source)
    if mask.shape != shape or mask.dtype.kind not in "bui":
        found = f"{mask.dtype} {mask.shape}"
        raise ShapeError(f"masks[{i}] must be bool or integer of shape {shape}, got {found}")
    return np.ascontiguousarray(mask != 0).astype(np.uint8)


def _correct(grey: F32, mask: U8 | None, corrections: Corrections, i: int) -> tuple[F32, U8 | None]:
    low, high = corrections.saturation
    counts = (grey >= low) & (grey <= high)
    value = grey.astype(np.float64)
    if corrections.response is not None:
        value = np.interp(value, np.arange(256.0), corrections.response)
    if corrections.vignette is not None:
        shared = len(corrections.vignette) == 1
        vignette = corrections.vignette[0 if shared else i]
        if vignette.shape != grey.shape:
            raise ShapeError(f"vignette is {vignette.shape}, images[{i}] is {grey.shape}")
        counts &= vignette >= _MIN_VIGNETTE
        value = value / np.maximum(vignette, _MIN_VIGNETTE)
    if corrections.exposure is not None:
        typical = float(np.exp(np.mean(np.log(corrections.exposure))))
        value = value * (typical / corrections.exposure[i])
    counts = counts if mask is None else counts & (mask != 0)
    return value.astype(np.float32), counts.astype(np.uint8)


def _rgb(pixels: AnyArray, order: ColorOrder) -> U8 | None:
    if pixels.ndim != 3:
        return None
    rgb = pixels if order is ColorOrder.RGB else pixels[:, :, ::-1]
    if rgb.dtype == np.uint8:
        return np.ascontiguousarray(rgb)
    scale = 257.0 if rgb.dtype == np.uint16 else 1.0
    return np.ascontiguousarray(np.clip(rgb / scale, 0, 255).astype(np.uint8))


def _undistort(
    undistorter: Undistorter, grey: F32, color: U8 | None, mask: U8 | None
) -> tuple[F32, U8 | None, U8]:
    seen = undistorter(np.ones(grey.shape, np.float32)) > 1.0 - 1e-4
    if mask is not None:
        seen &= undistorter(mask.astype(np.float32)) > 1.0 - 1e-4
    new_color = None if color is None else undistorter(color)
    new_grey = undistorter(grey, interpolation=Interpolation.CUBIC)
    return new_grey, new_color, seen.astype(np.uint8)


def _intrinsics(K: npt.ArrayLike) -> F64:
    """(1, 4) or (M, 4)."""
    array = np.asarray(K)
    if array.shape == (4,) or (array.ndim == 2 and array.shape[1] == 4):
        return as_f64(np.atleast_2d(array), "K", (None, 4))
    matrices = as_f64(array[None] if array.ndim == 2 else array, "K", (None, 3, 3))
    for M in matrices:
        if M[0, 1] != 0.0 or M[1, 0] != 0.0 or M[2].tolist() != [0.0, 0.0, 1.0]:
            raise OptionsError(f"K must be [fx 0 cx; 0 fy cy; 0 0 1], got {M.tolist()}")
    return np.stack(
        [matrices[:, 0, 0], matrices[:, 1, 1], matrices[:, 0, 2], matrices[:, 1, 2]], axis=1
    )


def _distorted(cameras: list[Camera], distortion: F64) -> list[Camera]:
    rows = np.atleast_2d(distortion)
    if rows.ndim != 2 or rows.shape[1] not in (4, 5) or len(rows) not in (1, len(cameras)):
        raise ShapeError(f"distortion must be k1 k2 p1 p2 [k3] per camera, got {distortion.shape}")
    if any(isinstance(camera, RadtanCamera) for camera in cameras):
        raise OptionsError("distortion must not be given beside cameras that have their own")
    rows = np.pad(rows, ((0, 0), (0, 5 - rows.shape[1])))
    return [
        RadtanCamera(c.fx, c.fy, c.cx, c.cy, *rows[i if len(rows) > 1 else 0])
        for i, c in enumerate(cameras)
    ]
