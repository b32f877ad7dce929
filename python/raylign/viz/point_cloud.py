"""Cameras and points seen from above and from the side."""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from raylign._typing import F64
from raylign.scene import BalProblem
from raylign.viz import style

_POINT_PERCENTILES = (2.0, 98.0)
_CAMERA_PERCENTILES = (1.0, 99.0)
_MARGIN = 0.04  # of the range, on each side
_REACH = 0.15  # of the percentile range: what may lie beyond it and still be shown
_DIRECTION_LENGTH = 0.035  # of the view's longer side
_MAX_CAMERAS = 1500  # drawn; of more, every n-th
_SPARSE_CAMERAS = 60  # with more, viewing directions are drawn shorter


@dataclass(frozen=True)
class _View:
    """A projection along an axis of the scene frame: which axes go right and up, their limits."""

    name: str
    axes: tuple[int, int]
    labels: tuple[str, str]
    low: F64  # (2,)
    high: F64  # (2,)

    @property
    def aspect(self) -> float:
        width, height = self.high - self.low
        return float(height / width)


@dataclass(frozen=True)
class _Scene:
    """Points, camera centres and viewing directions in the scene frame (right, forward, up)."""

    points: F64
    centers: F64
    directions: F64


@style.styled
def plot_point_cloud(
    before: BalProblem,
    after: BalProblem | None = None,
    *,
    max_points: int = 60_000,
    subtitle: str = "",
) -> Figure:
    """Draw the reconstruction from above and from the side, before and after a solve.

    Up is the mean of the cameras' up axes. Axes limits come from percentiles, so that a few points
    at infinity do not shrink the scene, and are the same before and after. Points take the
    problem's colours, or their height when it has none.

    Args:
        before: the problem before the solve.
        after: the same problem after it; None draws one column.
        max_points: draw at most this many points (a fixed random choice).
        subtitle: of the figure. Default: the size of the problem.

    Returns:
        Figure with one row per view and one column per problem.

    Raises:
        ShapeError: a problem has no camera or no point.
    """
    style.require_content("plot_point_cloud", before, *([] if after is None else [after]))
    problems = [before] if after is None else [before, after]
    frame = _scene_frame(problems[-1])
    origin = np.median(problems[-1].camera_centers(), axis=0)
    scenes = [_in_frame(problem, frame, origin) for problem in problems]
    views = _views(scenes)
    chosen = _choose(before.num_points, max_points)
    colors, norm = _point_colors(problems[-1], scenes[-1], views[1], chosen)

    column = 6.4 if len(problems) == 1 else 5.6
    heights = [max(0.25, view.aspect) for view in views]
    note = "" if len(chosen) == before.num_points else f" ({style.count(len(chosen))} points drawn)"
    figure = style.new_figure(
        column * len(problems) + 0.9,
        min(14.0, (column - 0.9) * sum(heights) + 2.0),
        "Reconstruction",
        (subtitle or style.size_text(before)) + note,
    )
    grid = figure.subplots(len(views), len(problems), squeeze=False, height_ratios=heights)
    titles = [""] if after is None else ["before: ", "after: "]
    for row, view in enumerate(views):
        for column_index, scene in enumerate(scenes):
            axes = grid[row, column_index]
            _draw(axes, scene, view, chosen, colors)
            axes.set_title(titles[column_index] + view.name)
    if norm is not None:
        mappable = ScalarMappable(norm, style.HEIGHT_COLORMAP)
        bar = figure.colorbar(mappable, ax=grid, shrink=0.6, aspect=40, pad=0.015)
        bar.set_label("height above the median camera [scene units]")
        bar.outline.set_visible(False)
    style.legend_below(figure, grid[0, 0])
    return figure


def _scene_frame(problem: BalProblem) -> F64:
    """Rows: right (longest horizontal spread of the cameras), forward, up; right-handed."""
    rotations = problem.T_cw()[:, :3, :3]
    up = rotations[:, 1, :].mean(axis=0)  # row 1 of R_cw: the camera's up axis in the world
    centers = problem.camera_centers()
    spread = centers - np.median(centers, axis=0)
    principal = np.linalg.svd(spread, full_matrices=True)[2]
    length = np.linalg.norm(up)
    # Cameras that look every way have no common up: the flattest direction of their path serves.
    up = principal[2] if length < 0.2 else up / length
    spread = spread - np.outer(spread @ up, up)
    right = np.linalg.svd(spread, full_matrices=True)[2][0]
    right = right - (right @ up) * up
    if np.linalg.norm(right) < 0.5:  # one camera, or all above each other
        right = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(up, right), up])


def _in_frame(problem: BalProblem, frame: F64, origin: F64) -> _Scene:
    rotations = problem.T_cw()[:, :3, :3]
    return _Scene(
        points=(problem.points - origin) @ frame.T,
        centers=(problem.camera_centers() - origin) @ frame.T,
        directions=-rotations[:, 2, :] @ frame.T,  # BAL cameras look along −z
    )


def _views(scenes: list[_Scene]) -> list[_View]:
    low, high = _robust_box(scenes)
    unit = "[scene units]"
    right, forward, up = f"right {unit}", f"forward {unit}", f"up {unit}"
    plan, side = [0, 1], [0, 2]
    return [
        _View("from above", (0, 1), (right, forward), low[plan], high[plan]),
        _View("from the side", (0, 2), (right, up), low[side], high[side]),
    ]


def _robust_box(scenes: list[_Scene]) -> tuple[F64, F64]:
    lows, highs = [], []
    for scene in scenes:
        points, centers = _finite(scene.points), _finite(scene.centers)
        if len(points):  # percentiles towards the middle: never the outlier itself
            low = np.percentile(points, _POINT_PERCENTILES[0], axis=0, method="higher")
            high = np.percentile(points, _POINT_PERCENTILES[1], axis=0, method="lower")
            reach = _REACH * (high - low)  # a cloud without outliers is shown whole
            lows.append(np.maximum(points.min(axis=0), low - reach))
            highs.append(np.minimum(points.max(axis=0), high + reach))
        if len(centers):  # away from the middle: of few cameras all
            lows.append(np.percentile(centers, _CAMERA_PERCENTILES[0], axis=0, method="lower"))
            highs.append(np.percentile(centers, _CAMERA_PERCENTILES[1], axis=0, method="higher"))
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    longest = max(float((high - low).max()), 1e-9)
    margin = np.maximum(_MARGIN * (high - low), 0.02 * longest)
    return low - margin, high + margin


def _finite(rows: F64) -> F64:
    return rows[np.isfinite(rows).all(axis=1)]


def _choose(num_points: int, max_points: int) -> np.ndarray:
    if num_points <= max_points:
        return np.arange(num_points)
    return np.sort(np.random.default_rng(0).choice(num_points, max_points, replace=False))


def _point_colors(
    problem: BalProblem, scene: _Scene, side: _View, chosen: np.ndarray
) -> tuple[np.ndarray, Normalize | None]:
    if len(problem.colors) == problem.num_points:
        return problem.colors[chosen] / 255.0, None
    import matplotlib as mpl

    norm = Normalize(float(side.low[1]), float(side.high[1]), clip=True)
    return mpl.colormaps[style.HEIGHT_COLORMAP](norm(scene.points[chosen, 2])), norm


def _draw(axes: Axes, scene: _Scene, view: _View, chosen: np.ndarray, colors: np.ndarray) -> None:
    horizontal, vertical = view.axes
    area = float(np.clip(24_000 / max(1, len(chosen)), 0.6, 8.0))
    points = scene.points[chosen]
    axes.scatter(
        points[:, horizontal],
        points[:, vertical],
        s=area,
        c=colors,
        linewidths=0,
        alpha=0.8,
        rasterized=True,
    )
    columns = [horizontal, vertical]
    # Thousands of cameras would be one black blot: every n-th is drawn, the same in every panel.
    step = math.ceil(len(scene.centers) / _MAX_CAMERAS)
    centers = scene.centers[::step, columns]
    crowd = min(1.0, (_SPARSE_CAMERAS / max(1, len(centers))) ** 0.5)
    length = _DIRECTION_LENGTH * crowd * float((view.high - view.low).max())
    tips = centers + length * scene.directions[::step, columns]
    thin = 0.9 if len(centers) <= 300 else 0.4
    axes.add_collection(
        LineCollection(
            list(np.stack([centers, tips], axis=1)), colors=style.BEFORE, linewidths=thin
        )
    )
    dot = 9.0 if len(centers) <= 300 else 3.0
    axes.scatter(centers[:, 0], centers[:, 1], s=dot, c=style.CAMERA, linewidths=0)
    every = "camera" if step == 1 else f"camera (1 of {step} drawn)"
    axes.plot([], [], ".", color=style.CAMERA, markersize=5, label=every)
    axes.plot([], [], color=style.BEFORE, linewidth=0.9, label="viewing direction")
    axes.plot([], [], ".", color=style.AFTER, markersize=4, label="point")
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    axes.set_aspect("equal")
    axes.set_xlabel(view.labels[0])
    axes.set_ylabel(view.labels[1])
