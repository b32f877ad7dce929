"""Images held in NumPy arrays, `image[v, u]`: pyramids, gradients, sampling, undistortion.

An image is an (H, W) or (H, W, 3) array of uint8, uint16 or float32; rows may be apart (a crop is
read in place), pixels within a row may not. What works on grey values takes them as float32 in
0..255: uint8 as is, uint16 / 257, float32 as is; colour is 0.299 R + 0.587 G + 0.114 B, with its
channels in the order `color_order`. A float pixel that is not finite is missing: whatever reads it
is missing as well, and nothing else.

    >>> import numpy as np
    >>> from raylign.camera import PinholeCamera
    >>> image = np.tile(np.arange(64, dtype=np.uint8), (48, 1))
    >>> pyramid = ImagePyramid(image)
    >>> [level.shape for level in pyramid]
    [(48, 64), (24, 32)]
    >>> pyramid[1][0, :3].tolist()
    [0.5, 2.5, 4.5]
    >>> PinholeCamera(50.0, 50.0, 31.5, 23.5).at_level(1)
    PinholeCamera(fx=25.0, fy=25.0, cx=15.5, cy=11.5)

Depth has a pyramid of its own, and a spline is worth keeping when it is sampled more than once:

    >>> D, V = np.full((2, 48, 64), np.float32([[[0.5]], [[1e-4]]]))
    >>> D[0, 0] = 0.0  # no depth there
    >>> coarse_D, coarse_V = DepthPyramid(D, V)[1]
    >>> float(coarse_D[0, 0]), coarse_V.shape
    (0.5, (24, 32))
    >>> values, gradients, valid = BSplineImage(image).sample([[20.25, 7.5]])
    >>> values.round(4).tolist(), gradients.round(4).tolist()
    ([20.25], [[1.0, 0.0]])
"""

import numpy as np

from raylign import _core
from raylign._core import (
    BSplineImage,
    ColorOrder,
    DepthPyramid,
    DepthPyramidOptions,
    ImagePyramid,
    Interpolation,
    PyramidOptions,
    SampleInterpolation,
)
from raylign._typing import F32, F64, AnyArray, Bool
from raylign.camera import PinholeCamera, RadtanCamera, undistort_map, without_distortion

__all__ = [
    "BSplineImage",
    "ColorOrder",
    "DepthPyramid",
    "DepthPyramidOptions",
    "ImagePyramid",
    "Interpolation",
    "PyramidOptions",
    "SampleInterpolation",
    "Undistorter",
    "gradient_image",
    "inscribed_camera",
    "max_gradient",
    "remap",
    "sample",
    "to_grey",
    "undistort",
]


def to_grey(image: AnyArray, *, color_order: ColorOrder = ColorOrder.RGB) -> F32:
    """Grey values 0..255 as float32, a copy.

    Args:
        image: (H, W) or (H, W, 3), uint8, uint16 (65535 becomes 255) or float32 (as is).
        color_order: of the channels; RGB: imageio, Pillow; BGR: OpenCV.

    Returns:
        (H, W) float32; colour is 0.299 R + 0.587 G + 0.114 B (luma of ITU-R BT.601, as OpenCV).

    Raises:
        ShapeError: `image` is not as above.

    Note: releases the GIL.

    Example:
        >>> to_grey(np.array([[[250, 0, 0], [255, 255, 255]]], np.uint8)).tolist()
        [[74.75, 255.0]]
    """
    return _core.to_grey(image, color_order=color_order)


def gradient_image(image: AnyArray, *, color_order: ColorOrder = ColorOrder.RGB) -> F32:
    """Grey value and gradient of every pixel, by central differences.

    One-sided at the border and 0 along a side of one pixel: where both exist, the gradient is that
    of numpy.gradient.

    Args:
        image: (H, W) or (H, W, 3), uint8, uint16 or float32.
        color_order: of the channels.

    Returns:
        (H, W, 4) float32: I, dI/du, dI/dv in grey levels per px, 0.

    Raises:
        ShapeError: `image` is not as above.

    Note: releases the GIL.

    Example:
        >>> gradient_image(np.array([[0, 10, 40]], np.uint8)).tolist()
        [[[0.0, 10.0, 0.0, 0.0], [10.0, 20.0, 0.0, 0.0], [40.0, 30.0, 0.0, 0.0]]]
    """
    return _core.gradient_image(image, color_order=color_order)


def max_gradient(image: AnyArray, *, color_order: ColorOrder = ColorOrder.RGB) -> F32:
    """Largest length of the gradient within 3x3 pixels: where an image has something to hold on to.

    Args:
        image: (H, W) or (H, W, 3), uint8, uint16 or float32.
        color_order: of the channels.

    Returns:
        (H, W) float32, grey levels per px; the gradient as in gradient_image, 0 where it is not
        finite.

    Raises:
        ShapeError: `image` is not as above.

    Note: releases the GIL.

    Example:
        >>> max_gradient(np.array([[0, 0, 0, 0, 8]], np.uint8)).tolist()
        [[0.0, 0.0, 4.0, 8.0, 8.0]]
    """
    return _core.max_gradient(image, color_order=color_order)


def sample(
    image: AnyArray,
    uv: AnyArray,
    *,
    interpolation: SampleInterpolation = SampleInterpolation.BILINEAR,
    color_order: ColorOrder = ColorOrder.RGB,
) -> tuple[F64, F64, Bool]:
    """Grey value and gradient between the pixels.

    Args:
        image: (H, W) or (H, W, 3), uint8, uint16 or float32; a float32 (H, W) image is not copied.
        uv: (..., 2) real, px, (0, 0) is the centre of the first pixel.
        interpolation: BILINEAR: the exact gradient of the bilinear interpolant, which jumps at
            pixels; CENTRAL_DIFFERENCE: the bilinear value with bilinearly interpolated central
            differences, smoother but not its derivative; CUBIC_BSPLINE: the cubic spline through
            all pixels, exact and smooth (see BSplineImage, which solves for it once).
        color_order: of the channels.

    Returns:
        values (...) and gradients (..., 2) = d value / d(u, v) per px, float64; valid (...) bool,
        True where 0 <= u <= W - 1, 0 <= v <= H - 1 and every pixel that was read is finite (4 for
        BILINEAR, 12 for CENTRAL_DIFFERENCE, 16 for CUBIC_BSPLINE). The others are NaN.

    Raises:
        ShapeError: shapes or dtypes are not as above.

    Note: releases the GIL.

    Example:
        >>> ramp = np.array([[0, 10, 20], [4, 14, 24]], np.uint8)
        >>> values, gradients, valid = sample(ramp, [[0.5, 0.25], [2.0, 1.0], [2.1, 0.0]])
        >>> values.tolist(), gradients[0].tolist(), valid.tolist()
        ([6.0, 24.0, nan], [10.0, 4.0], [True, True, False])
    """
    values, gradients, valid = _core.sample(
        image, uv, interpolation=interpolation, color_order=color_order
    )
    return values, gradients, valid


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


def inscribed_camera(
    camera: PinholeCamera | RadtanCamera, *, width: int, height: int
) -> PinholeCamera:
    """The widest pinhole camera, up to 1e-3 in f, whose whole image the given camera sees.

    Args:
        camera: camera of the images to undistort.
        width: columns of its images and of the new ones, px, >= 1.
        height: rows, px, >= 1.

    Returns:
        A camera with the principal point and the ratio fx / fy of `camera`, f scaled by a factor in
        [1/8, 8]; at 8 when even that has pixels that the camera does not see.

    Example:
        >>> barrel = RadtanCamera(100.0, 100.0, 31.5, 23.5, -0.2, 0.0, 0.0, 0.0)
        >>> inscribed_camera(barrel, width=64, height=48).fx < 100.0
        True
    """
    u, v = np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64)
    border = np.concatenate(
        [np.stack([u, np.full_like(u, row)], 1) for row in (0.0, height - 1.0)]
        + [np.stack([np.full_like(v, column), v], 1) for column in (0.0, width - 1.0)]
    )

    def scaled(factor: float) -> PinholeCamera:
        return PinholeCamera(camera.fx * factor, camera.fy * factor, camera.cx, camera.cy)

    def sees_all(factor: float) -> bool:
        rays, _ = scaled(factor).unproject(border)
        uv, valid = camera.project(rays)
        inside = (uv >= 0.0) & (uv <= [width - 1.0, height - 1.0])
        return bool((valid & inside.all(axis=1)).all())

    low, high = np.log(1 / 8), np.log(8)
    while high - low > 1e-3:
        middle = (low + high) / 2
        low, high = (low, middle) if sees_all(np.exp(middle)) else (middle, high)
    return scaled(float(np.exp(high)))


class Undistorter:
    """Turns the images of one camera into those of a pinhole camera; the maps are made once.

    Args:
        camera: camera that took the images.
        width: columns of its images, px, >= 1.
        height: rows of its images, px, >= 1.
        new_camera: the pinhole camera of the result, an image of the same size; default: that of
            `camera` without its distortion. inscribed_camera() gives one without black borders.

    Raises:
        ShapeError: a size is < 1.

    Example:
        >>> camera = RadtanCamera(100.0, 100.0, 31.5, 23.5, -0.2, 0.0, 0.0, 0.0)
        >>> undistorter = Undistorter(camera, width=64, height=48)
        >>> undistorter(np.full((48, 64), 9, np.uint8))[24, 32]
        np.uint8(9)
        >>> undistorter.camera
        PinholeCamera(fx=100.0, fy=100.0, cx=31.5, cy=23.5)
    """

    def __init__(
        self,
        camera: PinholeCamera | RadtanCamera,
        *,
        width: int,
        height: int,
        new_camera: PinholeCamera | None = None,
    ) -> None:
        self.camera = new_camera or without_distortion(camera)
        self._map = undistort_map(camera, self.camera.matrix(), width=width, height=height)

    def __call__(
        self, image: AnyArray, *, interpolation: Interpolation = Interpolation.LINEAR
    ) -> AnyArray:
        """The image as `self.camera` would have taken it; 0 where the old one did not look.

        Args:
            image: (H, W) or (H, W, 3), uint8, uint16 or float32, of the size given before.
            interpolation: NEAREST for depth, whose pixels must not be mixed.

        Returns:
            (H, W) or (H, W, 3) array of the dtype of `image`.

        Raises:
            ShapeError: `image` is not as above.
        """
        shape = self._map[0].shape
        if np.shape(image)[:2] != shape:
            message = f"image must have {shape[1]} x {shape[0]} pixels, got {np.shape(image)}"
            raise _core.ShapeError(message)
        return remap(image, *self._map, interpolation=interpolation)


def undistort(
    image: AnyArray,
    camera: PinholeCamera | RadtanCamera,
    *,
    new_camera: PinholeCamera | None = None,
    interpolation: Interpolation = Interpolation.LINEAR,
) -> tuple[AnyArray, PinholeCamera]:
    """Remove the distortion of one image; an Undistorter is faster for many.

    Args:
        image: (H, W) or (H, W, 3), uint8, uint16 or float32.
        camera: camera that took it.
        new_camera: as of Undistorter.
        interpolation: NEAREST for depth, whose pixels must not be mixed.

    Returns:
        The image, 0 where the old one did not look, and its pinhole camera.

    Raises:
        ShapeError: `image` is not as above.

    Example:
        >>> depth = np.full((48, 64), 1500, np.uint16)
        >>> camera = RadtanCamera(60.0, 60.0, 31.5, 23.5, -0.2, 0.0, 0.0, 0.0)
        >>> new_depth, pinhole = undistort(depth, camera, interpolation=Interpolation.NEAREST)
        >>> np.unique(new_depth).tolist(), pinhole.matrix()[0].tolist()
        ([1500], [60.0, 0.0, 31.5])
    """
    if np.ndim(image) < 2:
        raise _core.ShapeError(f"image must be (H, W) or (H, W, 3), got {np.shape(image)}")
    height, width = np.shape(image)[:2]
    undistorter = Undistorter(camera, width=width, height=height, new_camera=new_camera)
    return undistorter(image, interpolation=interpolation), undistorter.camera
