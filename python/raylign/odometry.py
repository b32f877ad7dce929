"""RGB-D odometry: the pose of each frame of a camera with depth, one after the other.

Each frame is aligned with the last keyframe by direct image alignment (`raylign.tracking`), with
the sensor's depth and its variance (`raylign.depth`). A frame whose alignment is not OK is tried
from other starts, with the frame before it, and with the recent keyframes; when nothing leads to
an OK alignment, its status is LOST, its pose NaN, and the next frame is looked for near the
keyframes.
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from raylign import _core
from raylign._core import (
    KeyframeRule,
    MotionModelOptions,
    OdometryOptions,
    OdometryResult,
    OdometryStatus,
    PinholeCamera,
    RadtanCamera,
    ShutterOptions,
)
from raylign._typing import F64, AnyArray
from raylign.camera import without_distortion
from raylign.image import Interpolation, Undistorter, inscribed_camera
from raylign.trajectory import Trajectory

__all__ = [
    "DepthFrame",
    "KeyframeRule",
    "MotionModelOptions",
    "OdometryOptions",
    "OdometryResult",
    "OdometryRun",
    "OdometryStatus",
    "Rectifier",
    "RgbdOdometry",
    "ShutterOptions",
    "has_pose",
    "run",
]


class RgbdOdometry:
    """Follows a camera with depth, frame by frame.

    Args:
        camera: pinhole of the rectified images.
        options: default: `OdometryOptions()`, one set for all sensors; `depth_scale` must fit
            16-bit depth images.
        T_wc: (4, 4) pose of the first frame, camera to world.

    Raises:
        OptionsError: an option is out of range.
        ShapeError: `T_wc` has another shape.

    Source: Engel, Schöps & Cremers, ECCV 2014, §3.3 (alignment), §3.4 (keyframes).
    """

    def __init__(
        self,
        camera: PinholeCamera,
        *,
        options: OdometryOptions | None = None,
        T_wc: AnyArray | None = None,
    ):
        self._core = _core.RgbdOdometry(
            camera,
            options=options or OdometryOptions(),
            T_wc=np.eye(4) if T_wc is None else T_wc,
        )

    @property
    def options(self) -> OdometryOptions:
        """A copy of the options."""
        return self._core.options

    def track(self, image: AnyArray, depth: AnyArray, *, timestamp: float) -> OdometryResult:
        """Find the pose of the next frame.

        Args:
            image: (H, W) or (H, W, 3) uint8, uint16 or float32 (0 to 255), rectified; every frame
                of the same size.
            depth: (H, W) float32 in m or uint16 in 1/depth_scale m, of the same camera; 0 and NaN
                where there is none.
            timestamp: s, larger than that of the frame before.

        Returns:
            status, pose and the whole AlignmentResult. A failure is a status, no exception.

        Raises:
            ShapeError: wrong dtype, shape or size.
            OptionsError: the time does not grow.

        Note: releases the GIL.
        """
        return self._core.track(image, depth, timestamp=timestamp)


class DepthFrame(Protocol):
    """What `run` needs of a frame; `raylign.io.RgbdFrame` is one."""

    @property
    def timestamp(self) -> float:
        """S."""

    @property
    def image(self) -> AnyArray:
        """(H, W) or (H, W, 3), as `RgbdOdometry.track` takes it."""

    @property
    def depth(self) -> AnyArray | None:
        """(H, W) float32 m or uint16; None where there is none."""


@dataclass(frozen=True, eq=False)
class OdometryRun:
    """What `run` returns.

    Attributes:
        camera: pinhole of the images that were tracked, distortion removed.
        results: one per frame, in order.
        times_s: (N,) s that `track` took for each frame, without reading or undistorting it.
        was_interrupted: stopped by Ctrl-C or by the callback; the results so far are kept.
    """

    camera: PinholeCamera
    results: tuple[OdometryResult, ...]
    times_s: F64
    was_interrupted: bool

    @property
    def trajectory(self) -> Trajectory:
        """Poses of the frames that have one."""
        tracked = [r for r in self.results if has_pose(r)]
        poses = np.array([r.T_wc for r in tracked]).reshape(-1, 4, 4)
        return Trajectory([r.timestamp for r in tracked], poses)

    @property
    def keyframes(self) -> list[int]:
        """Positions in `results` of the frames that became keyframes."""
        return [i for i, r in enumerate(self.results) if r.is_keyframe]

    @property
    def num_lost(self) -> int:
        """Frames without a pose."""
        return sum(not has_pose(r) for r in self.results)


def has_pose(result: OdometryResult) -> bool:
    """Whether the frame was tracked.

    Args:
        result: of `RgbdOdometry.track`.
    """
    return result.status in (OdometryStatus.OK, OdometryStatus.RECOVERED)


def run(
    frames: Iterable[DepthFrame],
    camera: PinholeCamera | RadtanCamera,
    *,
    options: OdometryOptions | None = None,
    T_wc: AnyArray | None = None,
    callback: Callable[[OdometryResult], bool | None] | None = None,
) -> OdometryRun:
    """Follow a camera through a sequence.

    Args:
        frames: in order of time, e.g. a `raylign.io.RgbdSequence`; a frame without depth can be
            tracked, but not become a keyframe.
        camera: of the images as they are; distortion is removed before tracking.
        options: default: `OdometryOptions()`.
        T_wc: (4, 4) pose of the first frame, camera to world. Default: identity.
        callback: called after each frame; return False to stop.

    Returns:
        OdometryRun. Ctrl-C ends the run early and keeps what there is.

    Raises:
        ShapeError: frames differ in size.
        OptionsError: an option is out of range, or time does not grow.
        FormatError: a file of the sequence cannot be read.
    """
    options = options or OdometryOptions()
    options.validate()
    odometry: RgbdOdometry | None = None
    rectifier: Rectifier | None = None
    results: list[OdometryResult] = []
    times_s: list[float] = []
    was_interrupted = False
    try:
        for frame in frames:
            image, depth = frame.image, frame.depth
            height, width = np.shape(image)[:2]
            if rectifier is None or odometry is None:
                rectifier = Rectifier(camera, width=width, height=height)
                odometry = RgbdOdometry(rectifier.camera, options=options, T_wc=T_wc)
            if depth is None:
                depth = np.zeros((height, width), np.float32)
            image, depth = rectifier.image(image), rectifier.depth(depth)
            start = time.perf_counter()
            result = odometry.track(image, depth, timestamp=frame.timestamp)
            times_s.append(time.perf_counter() - start)
            results.append(result)
            if callback is not None and callback(result) is False:
                was_interrupted = True
                break
    except KeyboardInterrupt:
        was_interrupted = True
    # an interrupt between two appends must not leave a time without its result
    times = np.array(times_s[: len(results)])
    # no frame, no size
    tracked = without_distortion(camera) if rectifier is None else rectifier.camera
    return OdometryRun(tracked, tuple(results), times, was_interrupted)


class Rectifier:
    """Images and depth of a camera as a pinhole camera would have taken them.

    The pinhole camera is the widest whose every pixel the images have: the black rim of an
    undistorted image would be tracked as if it were the scene. A pinhole camera's images are
    passed through.

    Args:
        camera: of the images as they are.
        width: columns of its images, px, >= 1.
        height: rows of its images, px, >= 1.

    Attributes:
        camera: of the rectified images.
    """

    def __init__(self, camera: PinholeCamera | RadtanCamera, *, width: int, height: int) -> None:
        self._undistorter: Undistorter | None = None
        if isinstance(camera, PinholeCamera):
            self.camera = camera
            return
        self.camera = inscribed_camera(camera, width=width, height=height)
        self._undistorter = Undistorter(camera, width=width, height=height, new_camera=self.camera)

    def image(self, image: AnyArray) -> AnyArray:
        """Return the rectified image.

        Args:
            image: (H, W) or (H, W, 3), uint8, uint16 or float32, of the size given before.
        """
        return image if self._undistorter is None else self._undistorter(image)

    def depth(self, depth: AnyArray) -> AnyArray:
        """Return rectified depth; depths are not mixed.

        Args:
            depth: (H, W) float32 or uint16, of the size given before.
        """
        if self._undistorter is None:
            return depth
        return self._undistorter(depth, interpolation=Interpolation.NEAREST)
