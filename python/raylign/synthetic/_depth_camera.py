"""Depth as a sensor reports it."""

from raylign import _core
from raylign._core import DepthSensorOptions, PinholeCamera, RadtanCamera
from raylign._typing import F32, F64
from raylign.synthetic._render import Frame


def sense_depth(
    frame: Frame,
    camera: PinholeCamera | RadtanCamera,
    *,
    options: DepthSensorOptions | None = None,
    seed: int = 0,
    index: int = 0,
) -> F32:
    """Make the depth image that a depth camera takes of a rendered frame.

    The inverse depth gets Gaussian noise with the sigma of `options.model`, is rounded to multiples
    of `inverse_depth_step`, and has holes: out of range, near steps of the depth, where the surface
    is seen at a grazing angle, and at random.

    Args:
        frame: what `render` returned.
        camera: the one it was rendered with.
        options: default: like a Kinect.
        seed: of the noise, unsigned 64-bit.
        index: of the frame: every frame has its own noise, in whatever order they are made.

    Returns:
        (H, W) float32 depth z in m; NaN where the sensor reports none.

    Raises:
        OptionsError: an option is out of range.

    Note: deterministic. Releases the GIL.

    Source: noise and grazing angle as in Nguyen, Izadi & Lovell, 3DIMPVT 2012; quantisation of
    structured light as in Khoshelham & Oude Elberink, Sensors 2012.

    Example:
        >>> import numpy as np
        >>> from raylign import camera, synthetic
        >>> pinhole = camera.PinholeCamera(100.0, 100.0, 31.5, 23.5)
        >>> frame = synthetic.render(synthetic.room(), pinhole, np.eye(4), width=64, height=48)
        >>> depth = synthetic.sense_depth(frame, pinhole)
        >>> error = (depth - frame.depth)[np.isfinite(depth)]
        >>> bool(0.005 < error.std() < 0.05)
        True
    """
    return _core.sense_depth(
        frame.depth,
        frame.normal,
        camera,
        options=options or DepthSensorOptions(),
        seed=seed,
        index=index,
    )


def noise_field(
    *, width: int, height: int, correlation_length: float = 0.0, seed: int = 0, index: int = 0
) -> F64:
    """Gaussian noise of mean 0 and variance 1 for every pixel, correlated or not.

    For noise of one's own making: `1 / (1 / depth + np.sqrt(V) * noise_field(...))` is a depth map
    whose inverse depth has variance V.

    Args:
        width: px, in [1, 32766].
        height: px, in [1, 32766].
        correlation_length: l in px, in [0, 64]: pixels d apart correlate by exp(−d² / (2 l²)).
        seed: unsigned 64-bit.
        index: of the frame, unsigned 64-bit.

    Returns:
        (H, W) float64.

    Raises:
        OptionsError: the length is out of range.
        ShapeError: the size is out of range.

    Example:
        >>> noise_field(width=4, height=3, seed=1).shape
        (3, 4)
    """
    return _core.noise_field(
        width=width,
        height=height,
        correlation_length=correlation_length,
        seed=seed,
        index=index,
    )
