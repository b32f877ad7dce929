"""Which unknowns meet in which residual: the patterns of J, H and S."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from raylign._typing import F64, I32, AnyArray
from raylign.scene import BalProblem
from raylign.viz import style

_CAMERA_DIM = 9
_POINT_DIM = 3
_RESIDUAL_DIM = 2
_MAX_CAMERAS = 16  # drawn block by block in J and H
_MAX_POINTS = 90
_MAX_S_CELLS = 500  # S is binned when it has more cameras than this
_CHUNK = 8192  # points at a time

_WHITE = (1.0, 1.0, 1.0)
_CAMERA_COLOR = (0.122, 0.478, 0.549)
_POINT_COLOR = (0.878, 0.627, 0.188)
_CROSS_COLOR = (0.784, 0.333, 0.239)


@dataclass(frozen=True)
class _Excerpt:
    """A part of the problem small enough to be drawn block by block, renumbered from 0."""

    num_cameras: int
    num_points: int
    camera: I32
    point: I32
    complete: bool


@style.styled
def plot_sparsity(problem: BalProblem) -> Figure:
    """Draw the block structure of J, H = JᵀJ and the reduced camera matrix S.

    J and H are drawn block by block (2x9, 2x3; 9x9, 3x3, 9x3) for the first cameras and an even
    choice of the points they see, ordered by the first camera that sees them; S for every camera,
    coloured by the number of points that two cameras share, in bins when there are too many.

    Args:
        problem: only its indices are used.

    Returns:
        Figure with three panels.

    Raises:
        ShapeError: the problem has no camera or no point.
    """
    style.require_content("plot_sparsity", problem)
    part = _excerpt(problem)
    figure = style.new_figure(14.5, 5.9, "Sparsity", style.size_text(problem))
    jacobian, hessian, reduced = figure.subplots(1, 3, width_ratios=[0.8, 1.05, 1.25])
    which = (
        "all of it"
        if part.complete
        else f"first {part.num_cameras} cameras, {part.num_points} of their points"
    )
    _draw_jacobian(jacobian, part)
    jacobian.set_title(f"J: {which}")
    _draw_hessian(hessian, part)
    hessian.set_title(f"H = JᵀJ: {which}")
    _draw_reduced(figure, reduced, problem)
    for color, name in (
        (_CAMERA_COLOR, "camera block"),
        (_POINT_COLOR, "point block"),
        (_CROSS_COLOR, "camera-point block"),
    ):
        jacobian.plot([], [], "s", color=color, label=name)
    style.legend_below(figure, jacobian)
    return figure


def _excerpt(problem: BalProblem) -> _Excerpt:
    cameras = min(problem.num_cameras, _MAX_CAMERAS)
    seen = problem.camera_index < cameras
    camera, point = problem.camera_index[seen], problem.point_index[seen]
    first = np.full(problem.num_points, cameras)
    np.minimum.at(first, point, camera)
    number = np.bincount(point, minlength=problem.num_points)
    # Tracks of one view inside the excerpt couple nothing: only if there are no others.
    candidates = np.flatnonzero(number >= 2)
    if len(candidates) == 0:
        candidates = np.flatnonzero(number >= 1)
    order = candidates[np.lexsort((candidates, first[candidates]))]
    if len(order) > _MAX_POINTS:
        order = order[np.linspace(0, len(order) - 1, _MAX_POINTS).round().astype(np.int64)]
    new_index = np.full(problem.num_points, -1)
    new_index[order] = np.arange(len(order))
    keep = new_index[point] >= 0
    camera, point = camera[keep], new_index[point[keep]]
    rows = np.lexsort((camera, point))
    complete = cameras == problem.num_cameras and len(order) == problem.num_points
    return _Excerpt(
        num_cameras=cameras,
        num_points=len(order),
        camera=camera[rows].astype(np.int32),
        point=point[rows].astype(np.int32),
        complete=complete,
    )


def _blank(rows: int, columns: int) -> F64:
    return np.broadcast_to(np.asarray(_WHITE), (max(rows, 1), max(columns, 1), 3)).copy()


def _fill(image: F64, row: int, column: int, height: int, width: int, color: AnyArray) -> None:
    image[row : row + height, column : column + width] = color


def _draw_jacobian(axes: Axes, part: _Excerpt) -> None:
    split = _CAMERA_DIM * part.num_cameras
    rows = _RESIDUAL_DIM * len(part.camera)
    image = _blank(rows, split + _POINT_DIM * part.num_points)
    camera_color, point_color = np.asarray(_CAMERA_COLOR), np.asarray(_POINT_COLOR)
    for k, (i, j) in enumerate(zip(part.camera, part.point, strict=True)):
        row = _RESIDUAL_DIM * k
        _fill(image, row, _CAMERA_DIM * i, _RESIDUAL_DIM, _CAMERA_DIM, camera_color)
        _fill(image, row, split + _POINT_DIM * j, _RESIDUAL_DIM, _POINT_DIM, point_color)
    _show(axes, image, split, None)
    axes.set_aspect("auto")
    axes.set_xlabel("unknown: 9 per camera | 3 per point")
    axes.set_ylabel("residual: 2 per observation")


def _draw_hessian(axes: Axes, part: _Excerpt) -> None:
    split = _CAMERA_DIM * part.num_cameras
    size = split + _POINT_DIM * part.num_points
    image = _blank(size, size)
    cross = np.asarray(_CROSS_COLOR)
    for i in range(part.num_cameras):
        at = _CAMERA_DIM * i
        _fill(image, at, at, _CAMERA_DIM, _CAMERA_DIM, np.asarray(_CAMERA_COLOR))
    for j in range(part.num_points):
        at = split + _POINT_DIM * j
        _fill(image, at, at, _POINT_DIM, _POINT_DIM, np.asarray(_POINT_COLOR))
    for i, j in zip(part.camera, part.point, strict=True):
        row, column = _CAMERA_DIM * i, split + _POINT_DIM * j
        _fill(image, row, column, _CAMERA_DIM, _POINT_DIM, cross)
        _fill(image, column, row, _POINT_DIM, _CAMERA_DIM, cross)
    _show(axes, image, split, split)
    axes.set_xlabel("unknown: cameras | points")
    axes.set_ylabel("unknown: cameras | points")


def _show(axes: Axes, image: F64, column_split: int, row_split: int | None) -> None:
    axes.imshow(image, interpolation="antialiased")
    axes.axvline(column_split - 0.5, color=style.MUTED, linewidth=0.8)
    if row_split is not None:
        axes.axhline(row_split - 0.5, color=style.MUTED, linewidth=0.8)
    axes.set_anchor("N")
    axes.grid(visible=False)


def _shared_points(problem: BalProblem, cells: int) -> F64:
    """Number of points that two cameras (or two bins of cameras) share, (cells, cells)."""
    cell = (problem.camera_index.astype(np.int64) * cells) // max(1, problem.num_cameras)
    order = np.argsort(problem.point_index, kind="stable")
    cell, point = cell[order], problem.point_index[order]
    shared = np.zeros((cells, cells))
    for first in range(0, problem.num_points, _CHUNK):
        begin, end = np.searchsorted(point, (first, first + _CHUNK))
        sees = np.zeros((_CHUNK, cells), np.float32)
        sees[point[begin:end] - first, cell[begin:end]] = 1.0
        shared += sees.T @ sees
    return shared


def _draw_reduced(figure: Figure, axes: Axes, problem: BalProblem) -> None:
    cells = min(problem.num_cameras, _MAX_S_CELLS)
    shared = _shared_points(problem, cells)
    filled = float(np.count_nonzero(shared)) / max(1, shared.size)
    extent = (-0.5, problem.num_cameras - 0.5, problem.num_cameras - 0.5, -0.5)
    image = axes.imshow(
        np.where(shared > 0, shared, np.nan),
        norm=LogNorm(1, max(2.0, float(shared.max()))),
        cmap="GnBu",
        interpolation="nearest" if cells <= 200 else "antialiased",
        extent=extent,
    )
    bar = figure.colorbar(image, ax=axes, shrink=0.85, pad=0.02)
    bar.set_label("points seen by both cameras")
    bar.outline.set_visible(False)
    binned = "" if cells == problem.num_cameras else f", in {cells} x {cells} bins"
    axes.set_title(
        f"S: all {style.count(problem.num_cameras)} cameras{binned}, {filled:.0%} non-zero"
    )
    axes.set_anchor("N")
    axes.set_xlabel("camera (9 unknowns each)")
    axes.set_ylabel("camera (9 unknowns each)")
    axes.grid(visible=False)
