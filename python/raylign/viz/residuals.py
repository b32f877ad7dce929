"""How far the predicted pixels are from the observed ones."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from raylign._typing import F64
from raylign.errors import ShapeError
from raylign.scene import BalProblem
from raylign.viz import style

_MIN_NORM_PX = 1e-4  # smaller norms share the first bin
_MAX_LINKED_CAMERAS = 150


@style.styled
def plot_residuals(
    before: BalProblem, after: BalProblem | None = None, *, median: bool = False
) -> Figure:
    """Draw the residual norms and each camera's RMSE before and after a solve, both on log axes.

    Args:
        before: the problem before the solve.
        after: the same problem after it; None draws `before` alone.
        median: add a panel with each camera's median norm, which outliers do not move: after a
            robust solve the RMSE says little.

    Returns:
        Figure with a histogram and the per-camera RMSE (px per coordinate), and the per-camera
        median of ‖r‖ (px) where asked for.

    Raises:
        ShapeError: a problem has no camera or no point, or the numbers of cameras differ.
    """
    problems = [before] if after is None else [before, after]
    style.require_content("plot_residuals", *problems)
    if problems[-1].num_cameras != before.num_cameras:
        raise ShapeError(
            f"plot_residuals: {before.num_cameras} cameras against {problems[-1].num_cameras}"
        )
    norms = [np.linalg.norm(problem.residuals(), axis=1) for problem in problems]
    figure = style.new_figure(17.0 if median else 13.5, 4.6, "Residuals", style.size_text(before))
    panels = figure.subplots(1, 3 if median else 2)
    _histogram(panels[0], norms)
    pairs = list(zip(problems, norms, strict=True))
    _per_camera(panels[1], [_camera_rmse(p, n) for p, n in pairs], "RMSE", "RMSE per coordinate")
    if median:
        _per_camera(panels[2], [_camera_median(p, n) for p, n in pairs], "median", "median ‖r‖")
    style.legend_below(figure, panels[0])
    return figure


def _histogram(axes: Axes, norms: list[F64]) -> None:
    everything = np.concatenate(norms)
    everything = everything[np.isfinite(everything)]
    if len(everything) == 0:
        axes.set_title("no observations")
        return
    # 0.05 % off each end: one residual of 1e5 px would flatten the rest into two bins.
    low, high = np.percentile(everything, (0.05, 99.95))
    low = max(_MIN_NORM_PX, float(low))
    bins = np.geomspace(low, max(float(high), low * 1.01), 70).tolist()
    for values, color, name in zip(
        norms, (style.BEFORE, style.AFTER), ("before", "after"), strict=False
    ):
        finite = values[np.isfinite(values)]
        if len(finite) == 0:
            continue
        rmse = float(np.sqrt(np.mean(finite**2) / 2.0))
        clipped = np.clip(finite, bins[0], bins[-1])
        label = f"{name}: median {np.median(finite):.3g} px, RMSE {rmse:.3g} px"
        axes.hist(clipped, bins, color=color, alpha=0.30)
        axes.hist(clipped, bins, color=color, histtype="step", linewidth=1.5, label=label)
        axes.axvline(float(np.median(finite)), color=color, linewidth=1.0, linestyle="--")
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(style.plain_number))
    axes.set_xlabel("residual norm ‖r‖ [px], log bins, ends collect the tails; dashed: median")
    axes.set_ylabel("observations per bin")
    axes.set_title("residual norms")


def _camera_rmse(problem: BalProblem, norms: F64) -> F64:
    """√(Σ ‖r‖² / 2n) over each camera's n finite residuals; NaN for a camera without any."""
    cameras = problem.num_cameras
    finite = np.isfinite(norms)
    index = problem.camera_index[finite]
    total = np.bincount(index, norms[finite] ** 2, minlength=cameras)
    number = np.bincount(index, minlength=cameras)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(total / (2.0 * number))


def _camera_median(problem: BalProblem, norms: F64) -> F64:
    """Median of each camera's finite residual norms; NaN for a camera without any."""
    finite = np.isfinite(norms)
    index, values = problem.camera_index[finite], norms[finite]
    order = np.lexsort((values, index))
    index, values = index[order], values[order]
    start = np.searchsorted(index, np.arange(problem.num_cameras))
    stop = np.searchsorted(index, np.arange(problem.num_cameras), side="right")
    median = np.full(problem.num_cameras, np.nan)
    seen = stop > start
    low, high = (start + stop - 1)[seen] // 2, (start + stop)[seen] // 2
    median[seen] = (values[low] + values[high]) / 2.0
    return median


def _per_camera(axes: Axes, values: list[F64], name: str, label: str) -> None:
    before, after = values[0], values[-1]
    index = np.arange(len(before))
    size = 16.0 if len(index) <= _MAX_LINKED_CAMERAS else 4.0
    if len(index) <= _MAX_LINKED_CAMERAS and len(values) == 2:
        ends = np.stack([np.column_stack([index, before]), np.column_stack([index, after])], axis=1)
        axes.add_collection(LineCollection(list(ends), colors="#cbd5e1", linewidths=1.2))
    for heights, color in zip(values, (style.BEFORE, style.AFTER), strict=False):
        axes.scatter(index, heights, s=size, color=color, linewidths=0)
    style.log_axis(axes, np.concatenate(values))
    axes.yaxis.set_major_formatter(FuncFormatter(style.plain_number))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("camera")
    axes.set_ylabel(f"{label} [px]")
    better = int(np.sum(after < before))
    change = f": lower in {better} of {len(index)}" if len(values) == 2 else ""
    axes.set_title(f"{name} per camera{change}")
