"""Camera models and undistortion.

`PinholeCamera` and `RadtanCamera` (Brown-Conrady, OpenCV's parameter order) look along +z, x
right, y down, pixels (u, v) = (column, row), integer at the pixel centre. `BalCamera` keeps the
axes of the BAL format: it looks along −z, v up, principal point at the origin.

A camera is an immutable value: parameters are read-only attributes, `==`, `hash`, `pickle` and
`copy` work. All methods take (..., 3) or (..., 2) arrays with any leading batch dimensions,
release the GIL and report points without an answer in `valid`, never by an exception:

    uv, valid = camera.project(p_c)
    uv, valid, J_point, J_params = camera.project_with_jacobians(p_c)
    bearing, valid = camera.unproject(uv)
    bearing, valid, J_uv, J_params = camera.unproject_with_jacobians(uv)

Source: Brown 1971; OpenCV's calib3d documentation; Agarwal et al., ECCV 2010 (BAL).
"""

import numpy.typing as npt

from raylign import _core
from raylign._core import BalCamera, PinholeCamera, RadtanCamera
from raylign._typing import F32

__all__ = ["BalCamera", "PinholeCamera", "RadtanCamera", "undistort_map", "without_distortion"]


def undistort_map(
    camera: PinholeCamera | RadtanCamera, K_new: npt.ArrayLike, *, width: int, height: int
) -> tuple[F32, F32]:
    """Where each pixel of a new pinhole image lies in the image of `camera`.

    Input of `image.remap`.

    As OpenCV's initUndistortRectifyMap with R = I, but pixels that the camera does not image
    (behind it or beyond the fold of its distortion polynomial) are sent far outside instead of
    to a wrong place.

    Args:
        camera: camera that took the image.
        K_new: (3, 3) real, invertible, upper triangular: the new pinhole, px.
        width: columns of the new image, px, >= 1.
        height: rows of the new image, px, >= 1.

    Returns:
        map_x, map_y: (height, width) float32, px of the old image; -1e4 where there is none.

    Raises:
        OptionsError: `K_new` is singular or not finite.
        ShapeError: `K_new` is not (3, 3), or a size is < 1.

    Example:
        >>> camera = PinholeCamera(100.0, 100.0, 15.5, 11.5)
        >>> map_x, map_y = undistort_map(camera, camera.matrix(), width=32, height=24)
        >>> float(map_x[3, 7]), float(map_y[3, 7])
        (7.0, 3.0)
    """
    return _core.undistort_map(camera, K_new, width=width, height=height)


def without_distortion(camera: PinholeCamera | RadtanCamera) -> PinholeCamera:
    """The pinhole with the same fx, fy, cx, cy (px): right for images that were undistorted.

    Example:
        >>> without_distortion(RadtanCamera(100.0, 101.0, 15.5, 11.5, -0.2, 0.1, 0.0, 0.0))
        PinholeCamera(fx=100.0, fy=101.0, cx=15.5, cy=11.5)
    """
    return PinholeCamera(camera.fx, camera.fy, camera.cx, camera.cy)
