"""Decoding of colour, depth and disparity images. cv2 is loaded with the first of them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raylign._typing import F32, U8, AnyArray
from raylign.io._streams import format_error

KINECT_SATURATED = 65535


@dataclass(frozen=True)
class DepthCodec:
    """How the numbers of a depth image become metres.

    Attributes:
        scale: numbers of an integer image per metre, or per pixel of disparity; 0: 256 for 16
            bits, else 1.
        disparity_fb: focal length · baseline, px·m, for disparity images: Z = f b / d; 0 for depth.
        max_depth: larger depths, m, count as not measured.
        flip: turn colour and depth upside down.
    """

    scale: float = 1000.0
    disparity_fb: float = 0.0
    max_depth: float = np.inf
    flip: bool = False

    def decode(self, raw: AnyArray) -> F32:
        """(H, W) numbers of the file to float32 m, NaN where nothing was measured.

        0, negative, not finite, and 65535 of a 16-bit image are no measurements.
        """
        value = raw.astype(np.float32)
        invalid = ~(np.isfinite(value) & (value > 0.0))
        if raw.dtype == np.uint16:
            invalid |= raw == KINECT_SATURATED
        if raw.dtype.kind in "ui":
            default = 256.0 if raw.dtype == np.uint16 else 1.0  # KITTI's disparity, plain pixels
            value /= np.float32(self.scale or default)
        if self.disparity_fb > 0.0:
            value[invalid] = 1.0
            np.divide(np.float32(self.disparity_fb), value, out=value)
        invalid |= value > self.max_depth
        value[invalid] = np.nan
        return np.ascontiguousarray(value[::-1] if self.flip else value)


def read_image(path: Path, *, size: tuple[int, int] = (0, 0), flip: bool = False) -> U8:
    """(H, W) or (H, W, 3) RGB uint8; `size` (width, height) is checked unless 0.

    Raises:
        FormatError: the file is missing, no image of 8 or 16 bits, or of another size.
    """
    image = read_pixels(path)
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    _check_size(path, image, size)
    return np.ascontiguousarray(image[::-1] if flip else image)


def read_pixels(path: Path) -> AnyArray:
    """(H, W) or (H, W, 3) RGB, uint8 or uint16 as the file has it; alpha is dropped.

    Raises:
        FormatError: the file is missing or no image of 8 or 16 bits.
    """
    import cv2

    image = _decode(path, cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION)
    if image.ndim == 3 and image.shape[2] == 4:
        image = image[:, :, :3]
    if image.ndim == 3 and image.shape[2] not in (1, 3):
        raise format_error(str(path), "", f"has {image.shape[2]} channels, expected 1 or 3")
    if image.dtype not in (np.uint8, np.uint16):
        raise format_error(str(path), "", f"holds {image.dtype}, expected 8 or 16 bits a channel")
    if image.ndim == 3:
        image = image[:, :, ::-1] if image.shape[2] == 3 else image[:, :, 0]
    return np.ascontiguousarray(image)


def read_depth(path: Path, codec: DepthCodec, *, size: tuple[int, int] = (0, 0)) -> F32:
    """(H, W) float32 m, NaN where not measured, of a PNG, TIFF, PFM, EXR or `.npy` file.

    Raises:
        FormatError: the file is missing, no one-channel image, or of another size.
    """
    import cv2

    if path.suffix == ".npy":
        try:
            raw = np.load(path, allow_pickle=False)
        except (OSError, ValueError, EOFError) as error:
            raise format_error(str(path), "", f"is no readable .npy file: {error}") from error
    else:
        raw = _decode(path, cv2.IMREAD_UNCHANGED)
    if raw.ndim == 3 and raw.shape[2] == 1:
        raw = raw[:, :, 0]
    if raw.ndim != 2 or raw.dtype.kind not in "uif":
        raise format_error(str(path), "", f"is no depth image: {raw.dtype} {raw.shape}")
    _check_size(path, raw, size)
    return codec.decode(raw)


def _decode(path: Path, flags: int) -> AnyArray:
    import cv2

    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise format_error(str(path), "", f"cannot be opened: {error.strerror}") from error
    try:
        image = cv2.imdecode(data, flags) if len(data) else None
    except cv2.error as error:  # a header that claims more than OpenCV allows
        raise format_error(str(path), "", f"is no readable image: {error}") from error
    if image is None:
        raise format_error(str(path), "", "is no readable image")
    return np.asarray(image)


def _check_size(path: Path, image: AnyArray, size: tuple[int, int]) -> None:
    found = (image.shape[1], image.shape[0])
    if size != (0, 0) and found != size:
        reason = f"is {found[0]}x{found[1]}, the calibration is for {size[0]}x{size[1]}"
        raise format_error(str(path), "", reason)
