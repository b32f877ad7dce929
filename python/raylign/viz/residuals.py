"""How far the predicted pixels are from the observed ones."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from raylign._typing import F64
from raylign.scene import BalProblem
from raylign.viz import style

_MIN_NORM_PX = 1e-4  # smaller norms share the first bin
_MAX_LINKED_CAMERAS = 150


@style.styled
def plot_residuals(before: BalProblem, after: BalProblem) -> Figure:
    """Draw the residual norms and each camera's RMSE before and after a solve, both on log axes.

    Args:
        before: the problem before the solve.
        after: the same problem after it.

    Returns:
        Figure with a histogram (left) and the per-camera RMSE (right), px per coordinate.
    """
    norms = [np.linalg.norm(problem.residuals(), axis=1) for problem in (before, after)]
    figure = style.new_figure(13.5, 4.6, "Residuals", style.size_text(before))
    left, right = figure.subplots(1, 2)
    _histogram(left, norms)
    rmse = [_camera_rmse(p, n) for p, n in zip((before, after), norms, strict=True)]
    _per_camera(right, rmse[0], rmse[1])
    style.legend_below(figure, left)
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
        norms, (style.BEFORE, style.AFTER), ("before", "after"), strict=True
    ):
        finite = values[np.isfinite(values)]
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


def _per_camera(axes: Axes, before: F64, after: F64) -> None:
    index = np.arange(len(before))
    size = 16.0 if len(index) <= _MAX_LINKED_CAMERAS else 4.0
    if len(index) <= _MAX_LINKED_CAMERAS:
        ends = np.stack([np.column_stack([index, before]), np.column_stack([index, after])], axis=1)
        axes.add_collection(LineCollection(list(ends), colors="#cbd5e1", linewidths=1.2))
    axes.scatter(index, before, s=size, color=style.BEFORE, linewidths=0)
    axes.scatter(index, after, s=size, color=style.AFTER, linewidths=0)
    style.log_axis(axes, np.append(before, after))
    axes.yaxis.set_major_formatter(FuncFormatter(style.plain_number))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("camera")
    axes.set_ylabel("RMSE per coordinate [px]")
    better = int(np.sum(after < before))
    axes.set_title(f"RMSE per camera: lower in {better} of {len(index)}")
