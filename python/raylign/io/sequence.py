"""What every reader of image sequences returns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, overload

import numpy as np

from raylign._typing import F32, F64, U8
from raylign.camera import PinholeCamera, RadtanCamera, without_distortion
from raylign.errors import OptionsError
from raylign.io._images import DepthCodec, read_depth, read_image
from raylign.trajectory import Trajectory

Camera: TypeAlias = PinholeCamera | RadtanCamera


@dataclass(frozen=True)
class SequenceReport:
    """What a reader found, left out and assumed.

    Attributes:
        num_images: colour images listed.
        num_depths: depth images listed.
        unpaired_images: stamps, s, of images without a depth image near in time; left out.
        unpaired_depths: stamps, s, of depth images without an image near in time; left out.
        missing_files: listed, but not on the disk; left out.
        num_duplicate_stamps: entries left out because their stamp was there already.
        time_offset_s: depth stamp − image stamp that the pairs were made with, s.
        max_difference_s: largest |image + offset − depth| of a pair, s.
        num_invalid_poses: frames whose true pose is missing or no rigid transform.
        notices: sentences for the user: assumed intrinsics, ignored things.
    """

    num_images: int = 0
    num_depths: int = 0
    unpaired_images: tuple[float, ...] = ()
    unpaired_depths: tuple[float, ...] = ()
    missing_files: tuple[str, ...] = ()
    num_duplicate_stamps: int = 0
    time_offset_s: float = 0.0
    max_difference_s: float = 0.0
    num_invalid_poses: int = 0
    notices: tuple[str, ...] = ()


@dataclass(frozen=True)
class Calibration:
    """The camera of a sequence.

    Attributes:
        camera: model and parameters, px.
        width: columns of its images, px; 0 = not known.
        height: rows of its images, px; 0 = not known.
        baseline: between the cameras of a stereo pair, m; 0 = none.
        source: where the numbers come from, for the user.
    """

    camera: Camera
    width: int = 0
    height: int = 0
    baseline: float = 0.0
    source: str = ""


@dataclass(frozen=True)
class RgbdFrame:
    """One frame; images are read when they are first asked for and kept as long as the frame.

    Attributes:
        index: position in the sequence that was opened (slices keep it).
        timestamp: of the image, s.
        image_path: file of the image.
        depth_path: file of the depth image; None where there is none.
        depth_timestamp: of the depth image, s.
    """

    index: int
    timestamp: float
    image_path: Path
    depth_path: Path | None = None
    depth_timestamp: float | None = None
    _codec: DepthCodec = field(default_factory=DepthCodec, repr=False)
    _size: tuple[int, int] = field(default=(0, 0), repr=False)

    @cached_property
    def image(self) -> U8:
        """(H, W) or (H, W, 3) RGB uint8.

        Raises:
            FormatError: the file is missing, no image, or of another size than the calibration.
        """
        return read_image(self.image_path, size=self._size, flip=self._codec.flip)

    @cached_property
    def depth(self) -> F32 | None:
        """(H, W) float32, m along the optical axis; NaN where it was not measured.

        None where the frame has no depth image.

        Raises:
            FormatError: the file is missing, no one-channel image, or of another size than the
                calibration.
        """
        if self.depth_path is None:
            return None
        return read_depth(self.depth_path, self._codec, size=self._size)


class RgbdSequence(Sequence[RgbdFrame]):
    """Images with or without depth, in order of time, read when asked for.

    `len`, iteration and indexing give `RgbdFrame`; `sequence[10:100:2]` is a sequence of those
    frames with the same calibration and truth.

    Attributes:
        name: of the folder.
        format: of the files: `tum`, `icl_nuim`, `seven_scenes`, `euroc`, `stereo`, `folder`.
        folder: where they lie.
        calibration: camera, image size, baseline, and where they come from.
        truth: poses T_wc of the camera on the clock of the images, or None.
        report: what was found, left out and assumed.
    """

    def __init__(
        self,
        frames: Sequence[RgbdFrame],
        *,
        format: str,
        folder: Path,
        calibration: Calibration,
        truth: Trajectory | None = None,
        report: SequenceReport | None = None,
    ) -> None:
        self.format = format
        self.folder = folder
        self.calibration = calibration
        self.truth = truth
        self.report = SequenceReport() if report is None else report
        self._frames = tuple(frames)

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.resolve().name

    @property
    def camera(self) -> Camera:
        """Model of the images as they are on the disk."""
        return self.calibration.camera

    @property
    def pinhole(self) -> PinholeCamera:
        """The camera without its distortion: right for undistorted images, else approximate."""
        return without_distortion(self.calibration.camera)

    @property
    def timestamps(self) -> F64:
        """(N,) float64, s, of the images."""
        return np.array([frame.timestamp for frame in self._frames])

    @property
    def has_depth(self) -> bool:
        """Whether any frame has a depth image."""
        return any(frame.depth_path is not None for frame in self._frames)

    def __len__(self) -> int:
        return len(self._frames)

    @overload
    def __getitem__(self, key: int) -> RgbdFrame: ...
    @overload
    def __getitem__(self, key: slice) -> "RgbdSequence": ...
    def __getitem__(self, key: int | slice) -> "RgbdFrame | RgbdSequence":
        if isinstance(key, slice):
            if key.step is not None and key.step < 0:
                raise OptionsError(f"a sequence runs forward in time, got step {key.step}")
            return self._with(self._frames[key])
        return replace(self._frames[key])  # without what the other one has read

    def __iter__(self) -> Iterator[RgbdFrame]:
        for frame in self._frames:
            yield replace(frame)

    def __repr__(self) -> str:
        truth = "no truth" if self.truth is None else f"{len(self.truth)} true poses"
        return f"<RgbdSequence: {self.name} ({self.format}), {len(self)} frames, {truth}>"

    def duplicate_images(self) -> list[int]:
        """Positions of frames whose image file equals that of the frame before, byte for byte.

        Some recordings (7-Scenes) repeat a colour image while the depth goes on. Reads the files
        of one size; takes a stat per frame and little more.
        """
        found = []
        for i in range(1, len(self._frames)):
            before, here = self._frames[i - 1].image_path, self._frames[i].image_path
            if before.stat().st_size == here.stat().st_size and (
                before.read_bytes() == here.read_bytes()
            ):
                found.append(i)
        return found

    def _with(self, frames: tuple[RgbdFrame, ...]) -> "RgbdSequence":
        changed: Any = object.__new__(RgbdSequence)
        changed.__dict__.update(self.__dict__, _frames=frames)
        return changed  # type: ignore[no-any-return]
