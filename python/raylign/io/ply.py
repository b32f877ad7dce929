"""Point clouds with cameras for viewers: binary little-endian PLY."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from raylign import _core
from raylign._typing import F64, U8, Bool, PathLike
from raylign.errors import OptionsError, ShapeError
from raylign.io._streams import path_or_stream
from raylign.scene import BalProblem

Color = tuple[float, float, float]

_FRUSTUM_DEPTH = 0.05  # of the scene's extent, as in the C++ writer
_FAR = 100.0  # times the extent


class PlySummary(NamedTuple):
    """What a PLY file holds, and what was left out: not finite, or (points) too far away."""

    num_points: int
    num_cameras: int
    num_skipped_points: int
    num_skipped_cameras: int
    num_far_points: int = 0


def write_ply(
    problem: BalProblem,
    path: PathLike,
    *,
    colors: npt.ArrayLike | None = None,
    cameras: bool = True,
    camera_scale: float | None = None,
    max_distance: float | None = None,
    camera_color: Color = (230, 60, 30),
    point_color: Color = (150, 150, 150),
) -> PlySummary:
    """Write points and cameras, drawn as frusta, for MeshLab, CloudCompare, Open3D or Blender.

    Vertices: the points, then six per camera (centre, four image corners, a tip above the image's
    upper edge). Faces: seven triangles per camera. World frame and units of the problem; a frustum
    opens along the camera's −z and is as wide as its observations reach.

    Args:
        problem: not modified.
        path: target; compressed when it ends in `.gz` or `.bz2`. Written to a temporary file
            beside it and renamed at the end.
        colors: (P, 3) RGB in [0, 255], rounded and clamped. Default: `problem.colors`, or
            `point_color` for all where the problem has none.
        cameras: draw the cameras.
        camera_scale: depth of a frustum in scene units, > 0. Default: 5 % of the median L1
            distance of the points from their median.
        max_distance: points whose L1 distance from the median point is larger, in scene units, are
            left out, so that viewers do not open on a dot. Default: 100 times the median of these
            distances; `inf` keeps all.
        camera_color: RGB in [0, 255], rounded and clamped.
        point_color: RGB in [0, 255], rounded and clamped; for points without colours.

    Returns:
        PlySummary: what was written, how many points and cameras were skipped because their
        coordinates are not finite, and how many points because they are too far away.

    Raises:
        OptionsError: `camera_scale` is not finite and > 0, `max_distance` is not > 0, or a colour
            is not finite.
        ShapeError: `colors` is not (P, 3), or the arrays of `problem` disagree.
        FormatError: the target cannot be written.
    """
    target = path_or_stream(path)
    if not isinstance(target, str):
        raise TypeError("write_ply needs a path")
    if camera_scale is not None and not 0.0 < camera_scale < float("inf"):
        raise OptionsError(f"camera_scale must be finite and > 0, got {camera_scale}")
    if max_distance is not None and not max_distance > 0.0:
        raise OptionsError(f"max_distance must be > 0, got {max_distance}")
    if colors is not None:
        problem = problem.replace(colors=_rgb(colors, (problem.num_points, 3), "colors"))
    problem.validate()
    distances = _distances(problem)
    known = np.isfinite(distances)
    extent = float(np.median(distances[known])) if known.any() else 0.0
    limit = _FAR * extent if max_distance is None else max_distance
    # Several points in one place have no extent, and no far points either.
    far = known & (distances > limit) if limit > 0.0 else np.zeros_like(known)
    counts = _core.write_ply(
        _without_points(problem, far),
        target,
        cameras=cameras,
        camera_scale=camera_scale or _FRUSTUM_DEPTH * extent,
        camera_color=_rgb(camera_color, (3,), "camera_color").tolist(),
        point_color=_rgb(point_color, (3,), "point_color").tolist(),
    )
    num_far = int(np.count_nonzero(far))
    num_points, num_cameras, num_skipped_points, num_skipped_cameras = counts
    return PlySummary(
        num_points, num_cameras, num_skipped_points - num_far, num_skipped_cameras, num_far
    )


def write_ply_points(
    points: F64,
    path: PathLike,
    *,
    colors: npt.ArrayLike | None = None,
    color: Color = (150, 150, 150),
) -> PlySummary:
    """Write a coloured point cloud, e.g. of keyframes.

    Args:
        points: (N, 3) float64, C order, world frame; points that are not finite are left out.
        path: target; compressed when it ends in `.gz` or `.bz2`. Written to a temporary file
            beside it and renamed at the end.
        colors: (N, 3) RGB in [0, 255], rounded and clamped. Default: `color` for all.
        color: RGB in [0, 255], rounded and clamped.

    Returns:
        PlySummary: what was written and what was left out.

    Raises:
        FormatError: the target cannot be written.
        ShapeError: an array has the wrong shape or dtype.
        OptionsError: a colour is not finite.
        TypeError: `path` is a file object.
    """
    nothing = np.zeros(0, np.int32)
    problem = BalProblem(np.zeros((0, 9)), points, nothing, nothing, np.zeros((0, 2)))
    return write_ply(
        problem, path, colors=colors, cameras=False, max_distance=np.inf, point_color=color
    )


def _distances(problem: BalProblem) -> F64:
    """L1 distance of each point from the median point, (P,); not finite where the point is not."""
    finite = problem.points[np.isfinite(problem.points).all(axis=1)]
    if len(finite) == 0:
        return np.full(problem.num_points, np.nan)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(np.abs(problem.points - np.median(finite, axis=0)).sum(axis=1))


def _without_points(problem: BalProblem, which: Bool) -> BalProblem:
    """Mark points as not finite, which the writer skips; the indices stay as they are."""
    if not which.any():
        return problem
    points = problem.points.copy()
    points[which] = np.nan
    return problem.replace(points=points)


def _rgb(values: npt.ArrayLike, shape: tuple[int, ...], name: str) -> U8:
    array = np.asarray(values)
    if array.shape != shape or array.dtype.kind not in "uif":
        raise ShapeError(
            f"{name} must be numbers of shape {shape}, got {array.dtype} {array.shape}"
        )
    if not np.isfinite(array).all():
        raise OptionsError(f"{name} must be finite")
    clamped: U8 = np.clip(np.rint(array), 0, 255).astype(np.uint8)
    return clamped
