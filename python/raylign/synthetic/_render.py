"""Images of scenes: ray casting, then the sensor."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from raylign import _core
from raylign._core import PinholeCamera, RadtanCamera, RenderOptions, Scene, SensorOptions
from raylign._typing import F64, I32, AnyArray, Bool


@dataclass(frozen=True)
class Frame:
    """What `render` returns; maps are (H, W), indexed [v, u].

    Attributes:
        image: uint8, uint16 or float32: what the sensor made of `irradiance`.
        irradiance: float64 grey values without noise, mean 128 for the default texture.
        depth: float64, z in the camera frame of the ray through the pixel centre, m; NaN where
            the ray meets nothing.
        normal: (H, W, 3) float64, unit, camera frame, towards the camera; NaN likewise.
        face: int32 face of the scene; −1 likewise.
        T_cw: (4, 4) float64 camera pose, at mid-exposure of the middle row if it moved.
    """

    image: AnyArray
    irradiance: F64
    depth: F64
    normal: F64
    face: I32
    T_cw: F64

    @property
    def valid(self) -> Bool:
        """(H, W) bool: the ray met a surface."""
        return self.face >= 0


def render(
    scene: Scene,
    camera: PinholeCamera | RadtanCamera,
    T_cw: npt.ArrayLike,
    *,
    width: int,
    height: int,
    options: RenderOptions | None = None,
    sensor: SensorOptions | None = None,
    motion: npt.ArrayLike | None = None,
    seed: int = 0,
    index: int = 0,
) -> Frame:
    """Take a picture of a scene, with the truth about it.

    Rays are cast through the pixel centres (see `RenderOptions` for anti-aliasing, motion blur and
    rolling shutter) and intersected analytically; textures are evaluated in double precision where
    the rays land. With `Antialiasing.NONE` one surface point has the same irradiance in every view
    to rounding; with BANDLIMIT (default) where no texture wave is shorter than 4 px in either.

    Args:
        scene: what is there, world frame, m.
        camera: pinhole, or Brown-Conrady; pixels that its distortion cannot reach see nothing.
        T_cw: (4, 4) world to camera.
        width: px, in [1, 32766].
        height: px, in [1, 32766].
        options: how rays become grey values.
        sensor: how irradiance becomes an image; default: uint8 without noise.
        motion: (6,) tangent [upsilon; omega] of the camera's motion per frame interval, m and rad:
            exp(tau motion) T_cw at time tau. Only motion blur and rolling shutter read it.
        seed: of the sensor noise, unsigned 64-bit.
        index: of the frame, so that the frames of a sequence have different noise in any order.

    Returns:
        Frame: image, irradiance, depth, normal, face, T_cw.

    Raises:
        OptionsError: an option is out of range, T_cw is not rigid, the camera is not valid.
        ShapeError: T_cw, motion or the image size has a wrong shape.

    Note: same bits for any number of threads. Releases the GIL.

    Example:
        >>> from raylign import camera, synthetic
        >>> pinhole = camera.PinholeCamera(100.0, 100.0, 31.5, 23.5)
        >>> wall = synthetic.plane(slant_deg=0.0, distance=2.0)
        >>> frame = synthetic.render(wall, pinhole, np.eye(4), width=64, height=48)
        >>> float(frame.depth.max()), float(frame.normal[..., 2].max())
        (2.0, -1.0)
    """
    pose = np.array(T_cw, np.float64)
    irradiance, depth, normal, face = _core.render(
        scene,
        camera,
        pose,
        width=width,
        height=height,
        options=options or RenderOptions(),
        motion=motion,
    )
    image = expose(irradiance, options=sensor, seed=seed, index=index)
    return Frame(image, irradiance, depth, normal, face, pose)


def expose(
    irradiance: npt.ArrayLike,
    *,
    options: SensorOptions | None = None,
    seed: int = 0,
    index: int = 0,
) -> AnyArray:
    """Make the image that a sensor takes of an irradiance map.

    Args:
        irradiance: (H, W) real grey values.
        options: exposure, vignette, response, noise and pixel format.
        seed: of the noise, unsigned 64-bit.
        index: of the frame: every frame has its own noise, in whatever order they are made.

    Returns:
        (H, W) uint8, uint16 or float32.

    Raises:
        OptionsError: an option is out of range.
        ShapeError: `irradiance` is not a map of real numbers.

    Note: deterministic. Releases the GIL.

    Example:
        >>> expose(np.full((1, 2), 100.0), options=SensorOptions(exposure=1.5)).tolist()
        [[150, 150]]
    """
    return _core.expose(irradiance, options=options or SensorOptions(), seed=seed, index=index)
