"""Write sequences in the format of the TUM RGB-D benchmark."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from raylign._typing import AnyArray, PathLike
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.errors import OptionsError
from raylign.io._streams import format_error
from raylign.io.trajectory import write_tum_trajectory
from raylign.io.tum import CALIBRATION_FILE
from raylign.trajectory import Trajectory

_MAX_RAW_DEPTH = 65534  # 65535 means saturated


class TumSequenceWriter:
    """Writes a sequence frame by frame: `rgb/`, `depth/`, lists, truth and `calibration.yaml`.

    The lists are written by `close()`, so an interrupted run leaves a valid, shorter sequence when
    used as a context manager.

    Args:
        folder: made if need be; must be empty.
        camera: of the images; written in OpenCV's YAML format.
        width: px.
        height: px.
        depth_scale: numbers per m of the 16-bit depth images, > 0.

    Raises:
        OptionsError: `depth_scale` is not > 0.
        FormatError: the folder is not empty or cannot be written.

    Example:
        >>> import pathlib, tempfile
        >>> from raylign.camera import PinholeCamera
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     camera = PinholeCamera(50.0, 50.0, 7.5, 5.5)
        ...     with TumSequenceWriter(folder, camera=camera, width=16, height=12) as writer:
        ...         writer.add(
        ...             0.5,
        ...             image=np.zeros((12, 16), np.uint8),
        ...             depth=np.ones((12, 16), np.float32),
        ...             T_wc=np.eye(4),
        ...         )
        ...     sorted(path.name for path in pathlib.Path(folder).iterdir())
        ['calibration.yaml', 'depth', 'depth.txt', 'groundtruth.txt', 'rgb', 'rgb.txt']
    """

    def __init__(
        self,
        folder: PathLike,
        *,
        camera: PinholeCamera | RadtanCamera,
        width: int,
        height: int,
        depth_scale: float = 5000.0,
    ) -> None:
        if not (np.isfinite(depth_scale) and depth_scale > 0.0):
            raise OptionsError(f"depth_scale must be finite and > 0, got {depth_scale}")
        self._folder = Path(folder)
        self._depth_scale = depth_scale
        self._stamps: list[float] = []
        self._poses: list[AnyArray] = []
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            if any(self._folder.iterdir()):
                raise format_error(str(folder), "", "is not empty")
            for kind in ("rgb", "depth"):
                (self._folder / kind).mkdir()
            text = calibration_yaml(camera, width=width, height=height) + _layout(depth_scale)
            (self._folder / CALIBRATION_FILE).write_text(text, encoding="ascii")
        except OSError as error:
            raise format_error(str(folder), "", f"cannot be written: {error.strerror}") from error

    def __enter__(self) -> "TumSequenceWriter":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def add(
        self, timestamp: float, *, image: AnyArray, depth: AnyArray, T_wc: npt.ArrayLike
    ) -> None:
        """Write one frame.

        Args:
            timestamp: s, later than the one before.
            image: (H, W) or (H, W, 3) RGB, uint8 or uint16.
            depth: (H, W) real, m; NaN, infinity and <= 0 mean: none. Depths beyond the range of the
                format, 65534 / depth_scale, are left out.
            T_wc: (4, 4) true pose.

        Raises:
            OptionsError: the stamp is not later than the one before.
            FormatError: a file cannot be written.
        """
        if self._stamps and not timestamp > self._stamps[-1]:
            raise OptionsError(f"timestamp must be > {self._stamps[-1]}, got {timestamp}")
        with np.errstate(invalid="ignore"):
            raw = np.rint(np.asarray(depth, np.float64) * self._depth_scale)
            known = (raw >= 1) & (raw <= _MAX_RAW_DEPTH)
        self._write("rgb", timestamp, image)
        self._write("depth", timestamp, np.where(known, raw, 0).astype(np.uint16))
        self._stamps.append(timestamp)
        self._poses.append(np.asarray(T_wc, np.float64))

    def close(self) -> None:
        """Write the lists and the truth of the frames so far."""
        if not self._stamps:
            return
        for kind, title in (("rgb", "color images"), ("depth", "depth maps")):
            rows = [f"{stamp:.6f} {kind}/{stamp:.6f}.png\n" for stamp in self._stamps]
            text = f"# {title}\n# timestamp filename\n" + "".join(rows)
            (self._folder / f"{kind}.txt").write_text(text, encoding="ascii")
        stamps = [round(stamp, 6) for stamp in self._stamps]
        truth = Trajectory(stamps, np.stack(self._poses))
        write_tum_trajectory(truth, self._folder / "groundtruth.txt")

    def _write(self, kind: str, timestamp: float, image: AnyArray) -> None:
        import cv2

        path = self._folder / kind / f"{timestamp:.6f}.png"
        pixels = image[..., ::-1] if image.ndim == 3 else image
        try:
            done = cv2.imwrite(str(path), np.ascontiguousarray(pixels))
        except cv2.error as error:
            raise format_error(str(path), "", f"cannot be encoded: {error.err}") from error
        if not done:
            raise format_error(str(path), "", "cannot be written")


def calibration_yaml(camera: PinholeCamera | RadtanCamera, *, width: int, height: int) -> str:
    """Camera matrix and distortion in the format of OpenCV's FileStorage."""
    fx, fy, cx, cy, *distortion = (float(value) for value in camera.params)
    coefficients = distortion or [0.0] * 5
    return (
        "%YAML:1.0\n---\n"
        f"image_width: {width}\nimage_height: {height}\n"
        + _matrix("camera_matrix", 3, [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])
        + _matrix("distortion_coefficients", 1, coefficients)
    )


def _layout(depth_scale: float) -> str:
    """What `read_image_folder` needs to know, which goes by this file."""
    return (
        "sequence:\n   images: rgb\n   depth: depth\n   truth: groundtruth.txt\n"
        f"   depth_scale: {depth_scale!r}\n"
    )


def _matrix(name: str, rows: int, values: list[float]) -> str:
    data = ", ".join(repr(value) for value in values)
    return (
        f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {len(values) // rows}\n"
        f"   dt: d\n   data: [ {data} ]\n"
    )
