"""Direct tracking: align frames with a keyframe by photometric, and depth, residuals.

A keyframe is an image with inverse depth and its variance. A frame is aligned with it by minimising
the variance-normalised photometric error of LSD-SLAM (Engel, Schöps & Cremers, ECCV 2014, section
3.3), with the depth residual beside it where the frame has depth, too. Images are rectified: the
camera is a pinhole.

    >>> import numpy as np
    >>> import raylign
    >>> v, u = np.mgrid[0:120, 0:160].astype(np.float32)
    >>> image = 128 + 40 * np.sin(u / 7) + 40 * np.cos(v / 9) + 20 * np.sin((u + 2 * v) / 11)
    >>> image = image.astype(np.float32)
    >>> camera = raylign.camera.PinholeCamera(fx=150.0, fy=150.0, cx=79.5, cy=59.5)
    >>> depth = np.full((120, 160), 0.5, np.float32)
    >>> keyframe = Keyframe(image, camera, inverse_depth=depth, variance=1e-6)
    >>> result = align(keyframe, image)
    >>> result.ok, bool(np.allclose(result.T_th, np.eye(4), atol=1e-6))
    (True, True)
"""

import numpy as np

from raylign import _core
from raylign._core import (
    AcceptanceOptions,
    AffineMode,
    AffineOptions,
    AlignmentMaps,
    AlignmentResult,
    AlignmentStatus,
    DepthTermOptions,
    GradientMode,
    KeyframeOptions,
    LevelResult,
    MotionGroup,
    NoiseModel,
    SigmaMode,
    TrackingOptions,
)
from raylign._typing import F32, F64, AnyArray
from raylign.camera import PinholeCamera
from raylign.errors import OptionsError

__all__ = [
    "AcceptanceOptions",
    "AffineMode",
    "AffineOptions",
    "AlignmentMaps",
    "AlignmentResult",
    "AlignmentStatus",
    "DepthTermOptions",
    "Frame",
    "GradientMode",
    "Keyframe",
    "KeyframeOptions",
    "LevelResult",
    "MotionGroup",
    "NoiseModel",
    "SigmaMode",
    "Tracker",
    "TrackingOptions",
    "align",
]


class Frame:
    """An image that can be tracked, and become a keyframe when it has depth.

    Args:
        image: (H, W) or (H, W, 3) RGB; uint8, uint16 or float32 grey levels 0..255. Rectified.
        camera: pinhole of the full image, px.
        inverse_depth: (H, W) float32, 1/scene unit; a pixel has depth where it and its variance are
            positive and finite. Default: no depth.
        variance: of the inverse depth, (H, W) float32 or one number for all.
        max_levels: of the pyramid, the full image included, >= 1.

    Raises:
        ShapeError: an array has another dtype or shape, or `variance` is missing.
        OptionsError: `max_levels` or the camera is out of range.

    Note: nothing is kept of the arrays. Releases the GIL.
    """

    def __init__(
        self,
        image: AnyArray,
        camera: PinholeCamera,
        *,
        inverse_depth: F32 | None = None,
        variance: F32 | float | None = None,
        max_levels: int = 5,
    ) -> None:
        if inverse_depth is not None and variance is None:
            raise OptionsError("variance must be given with inverse_depth")
        if inverse_depth is not None and not isinstance(variance, np.ndarray):
            variance = np.full(np.shape(inverse_depth), variance, np.float32)
        self._core = _core.TrackingFrame(
            image,
            camera,
            inverse_depth=inverse_depth,
            variance=variance,
            max_levels=max_levels,
        )

    @property
    def num_levels(self) -> int:
        """Levels of the pyramid; none has a side under 16 px but the first."""
        return self._core.num_levels

    @property
    def has_depth(self) -> bool:
        """Whether it was made with inverse depth."""
        return self._core.has_depth


class Keyframe:
    """A frame with depth, and the points that are chosen from it on each level.

    Args:
        image: as `Frame`.
        camera: as `Frame`.
        inverse_depth: as `Frame`; required.
        variance: as `Frame`; required.
        options: which pixels become points. Default: `KeyframeOptions()`.
        max_levels: of the pyramid, the full image included, >= 1.

    Raises:
        ShapeError: an array has another dtype or shape.
        OptionsError: an option, `max_levels` or the camera is out of range.

    Note: point lists are built when a level is first tracked on. Safe from several threads.
    """

    def __init__(
        self,
        image: AnyArray,
        camera: PinholeCamera,
        *,
        inverse_depth: F32,
        variance: F32 | float,
        options: KeyframeOptions | None = None,
        max_levels: int = 5,
    ) -> None:
        frame = Frame(
            image, camera, inverse_depth=inverse_depth, variance=variance, max_levels=max_levels
        )
        self._set(frame, options)

    @classmethod
    def from_frame(cls, frame: Frame, *, options: KeyframeOptions | None = None) -> "Keyframe":
        """Keyframe of a frame with depth, without a copy of it.

        Args:
            frame: with inverse depth.
            options: which pixels become points.

        Raises:
            ShapeError: the frame has no depth.
            OptionsError: an option is out of range.
        """
        keyframe = cls.__new__(cls)
        keyframe._set(frame, options)
        return keyframe

    def _set(self, frame: Frame, options: KeyframeOptions | None) -> None:
        self._core = _core.TrackingKeyframe(
            frame._core, options=KeyframeOptions() if options is None else options
        )

    @property
    def num_levels(self) -> int:
        """Levels of the pyramid."""
        return self._core.num_levels

    @property
    def options(self) -> KeyframeOptions:
        """A copy of the options."""
        return self._core.options

    def points(self, *, level: int = 0) -> F32:
        """Points of a level.

        Args:
            level: 0 is the full image.

        Returns:
            (P, 7) float32: u, v (px of the level), inverse depth, its variance, intensity, and the
            gradient (grey levels per px).

        Raises:
            OptionsError: there is no such level.
        """
        return self._core.points(level)


class Tracker:
    """Aligns one frame after the other with a keyframe; each starts where the last one ended.

    Keeps threads and memory between frames, so it is the faster way to align many.

    Args:
        options: how to align. Default: `TrackingOptions()`.

    Raises:
        OptionsError: an option is out of range.

    Example:
        >>> tracker = Tracker(options=TrackingOptions(finest_level=0))
        >>> tracker.keyframe is None
        True
    """

    def __init__(self, *, options: TrackingOptions | None = None) -> None:
        self._aligner = _core.Aligner(TrackingOptions() if options is None else options)
        self._keyframe: Keyframe | None = None
        self._last: AlignmentResult | None = None

    @property
    def options(self) -> TrackingOptions:
        """A copy of the options."""
        return self._aligner.options

    @property
    def keyframe(self) -> Keyframe | None:
        """What frames are aligned with."""
        return self._keyframe

    def set_keyframe(self, keyframe: Keyframe) -> None:
        """Align with this keyframe from now on, starting at the identity.

        Args:
            keyframe: the new one.
        """
        self._keyframe = keyframe
        self._last = None

    def track(
        self, frame: Frame, *, T_init: F64 | None = None, maps: bool = False
    ) -> AlignmentResult:
        """Align a frame with the keyframe.

        Args:
            frame: to align; its depth, where it has some, is used.
            T_init: (4, 4) start of T_th. Default: the last result that was OK, else the identity.
            maps: fill `result.maps`.

        Returns:
            AlignmentResult: look at `status` before using `T_th`.

        Raises:
            OptionsError: there is no keyframe, or `T_init` is no rigid motion.

        Note: releases the GIL.
        """
        if self._keyframe is None:
            raise OptionsError("Tracker.keyframe must be set before a frame is tracked")
        last = self._last
        result = self._aligner.align(
            self._keyframe._core,
            frame._core,
            T_init=_start(T_init, last),
            a=last.a if last is not None else 0.0,
            b=last.b if last is not None else 0.0,
            maps=maps,
        )
        if result.ok:
            self._last = result
        return result


def align(
    keyframe: Keyframe,
    image: AnyArray | Frame,
    *,
    T_init: F64 | None = None,
    options: TrackingOptions | None = None,
    camera: PinholeCamera | None = None,
    inverse_depth: F32 | None = None,
    variance: F32 | float | None = None,
    maps: bool = False,
) -> AlignmentResult:
    """Find the motion from a keyframe to another image.

    Minimises Σ ρ(r² / σ_r²) over T_th, coarse to fine, with r = I_h(p) − (e^a I_t(p') + b),
    p' = π(T_th π⁻¹(p, D)) and σ_r² = 2 σ_I² + (∂r/∂D)² V; with depth of the image, the residual
    1/Z' − D_t(p') beside it.

    Args:
        keyframe: host.
        image: target: a `Frame`, or an array as `Frame` takes it.
        T_init: (4, 4) start of T_th, which maps points of the keyframe into the target's frame.
            Default: identity.
        options: Default: `TrackingOptions()`.
        camera: of the target, when `image` is an array. Default: the keyframe's.
        inverse_depth: of the target, when `image` is an array; (H, W) float32, 1/scene unit.
        variance: of that, (H, W) float32 or one number.
        maps: fill `result.maps`.

    Returns:
        AlignmentResult: look at `status` before using `T_th`. What the images hold is never an
        exception.

    Raises:
        ShapeError: an array has another dtype or shape.
        OptionsError: an option is out of range, or `T_init` is no rigid motion (SIM3: similarity).

    Note: the same bits for any number of threads. Releases the GIL.

    Source:
        Engel, Schöps & Cremers, LSD-SLAM, ECCV 2014, equations 12 to 15.

    Example:
        >>> import raylign
        >>> image = np.random.default_rng(0).uniform(0, 255, (48, 64)).astype(np.float32)
        >>> camera = raylign.camera.PinholeCamera(fx=60.0, fy=60.0, cx=31.5, cy=23.5)
        >>> depth = np.full((48, 64), 0.5, np.float32)
        >>> keyframe = Keyframe(image, camera, inverse_depth=depth, variance=1e-6)
        >>> result = align(keyframe, image, options=TrackingOptions(finest_level=0))
        >>> result.status.name, result.T_th.shape
        ('OK', (4, 4))
    """
    if not isinstance(image, Frame):
        image = Frame(
            image,
            keyframe._core.camera if camera is None else camera,
            inverse_depth=inverse_depth,
            variance=variance,
            max_levels=keyframe.num_levels,
        )
    aligner = _core.Aligner(TrackingOptions() if options is None else options)
    return aligner.align(
        keyframe._core, image._core, T_init=_start(T_init, None), a=0.0, b=0.0, maps=maps
    )


def _start(T_init: F64 | None, last: AlignmentResult | None) -> F64:
    if T_init is not None:
        return T_init
    return np.eye(4) if last is None else last.T_th
