"""Cost against time and against iterations."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from raylign._typing import F64, AnyArray, Bool
from raylign.bundle import BundleResult, Summary
from raylign.errors import ShapeError
from raylign.viz import style


@style.styled
def plot_cost(summary: Summary | BundleResult[Any], *, subtitle: str = "") -> Figure:
    """Draw how the cost fell: against wall time, against iterations, and what the solver saw.

    Args:
        summary: of a solve, or what `adjust` returned; needs at least row 0.
        subtitle: problem size, for the title.

    Returns:
        Figure with three panels: cost over seconds, cost over iterations (rejected steps crossed,
        steps that could not be evaluated as triangles on the held cost), gradient, step and damping
        over iterations, the norm of rejected steps crossed.

    Raises:
        ShapeError: the summary has no iterations.
    """
    if isinstance(summary, BundleResult):
        summary = summary.summary
    rows = summary.iterations
    if len(rows) == 0:
        raise ShapeError("plot_cost: the summary has no iterations")
    best = _best_cost(rows)
    figure = style.new_figure(13.5, 4.4, "Cost", subtitle)
    over_time, over_iterations, state = figure.subplots(1, 3)

    _cost_curve(over_time, rows["cumulative_time_s"], best, rows)
    over_time.set_xlabel("wall time [s]")
    over_time.set_xlim(left=0)
    over_time.set_title("cost against time")

    _cost_curve(over_iterations, rows["iteration"], best, rows)
    above = best - best[-1]
    if (above > 0).any():
        x = rows["iteration"][above > 0]
        style_above = {"color": style.ACCENT, "markersize": 2.0, "linewidth": 1.2}
        over_iterations.plot(x, above[above > 0], "-o", label="cost above the final", **style_above)
        style.log_axis(over_iterations, np.append(best, above))
    over_iterations.set_xlabel("iteration")
    _end_at(over_iterations, rows["iteration"][-1])
    over_iterations.xaxis.set_major_locator(MaxNLocator(integer=True))
    over_iterations.set_title(f"{best[0]:.5g} → {best[-1]:.5g} in {len(rows) - 1} iterations")

    _state_curves(state, rows)
    state.set_xlabel("iteration")
    state.xaxis.set_major_locator(MaxNLocator(integer=True))
    state.set_title("gradient, step, damping")
    style.legend_below(figure, over_iterations)
    return figure


def _best_cost(rows: AnyArray) -> F64:
    """Cost of the state that the solver holds after each row: rejected trials do not count."""
    held = np.where(rows["step_is_accepted"] | (rows["iteration"] == 0), rows["cost"], np.inf)
    return np.minimum.accumulate(held)


def _failed(rows: AnyArray) -> tuple[Bool, Bool]:
    """Which rows are steps that were evaluated and rejected, and steps that were not valid."""
    refused = ~rows["step_is_accepted"] & (rows["iteration"] > 0)
    return refused & rows["step_is_valid"], refused & ~rows["step_is_valid"]


def _cost_curve(axes: Axes, x: AnyArray, cost: F64, rows: AnyArray) -> None:
    rejected, invalid = _failed(rows)
    marker = 3.5 if len(cost) <= 80 else 2.0
    axes.plot(x, cost, "-o", color=style.AFTER, markersize=marker, label="cost ½ Σ ρ(‖r‖²)")
    if rejected.any():
        axes.plot(x[rejected], cost[rejected], "x", color=style.BEFORE, label="rejected step")
    if invalid.any():
        axes.plot(x[invalid], cost[invalid], "v", color=style.ACCENT, label="invalid step")
    axes.axhline(cost[-1], color=style.MUTED, linewidth=0.8, linestyle=":", label="final cost")
    axes.set_ylabel("cost [px²]")
    style.log_axis(axes, cost)


def _end_at(axes: Axes, last: int) -> None:
    """End the axis at the last iteration, with room for half a marker."""
    margin = 0.02 * max(1.0, float(last))
    axes.set_xlim(-margin, float(last) + margin)


def _state_curves(axes: Axes, rows: AnyArray) -> None:
    curves = (
        ("gradient_max_norm", style.AFTER, "max |g|"),
        ("step_norm", style.ACCENT, "‖δ‖"),
        ("lambda", style.BEFORE, "λ"),
    )
    axes.set_yscale("log")
    for field, color, symbol in curves:
        keep = (rows[field] > 0) & (rows["step_is_accepted"] | (field != "step_norm"))
        if not keep.any():
            continue
        x, y = rows["iteration"][keep], rows[field][keep]
        axes.plot(x, y, "-o", color=color, markersize=2.5, linewidth=1.2)
        axes.annotate(
            symbol,
            (x[-1], y[-1]),
            xytext=(5, 0),
            textcoords="offset points",
            color=color,
            va="center",
            annotation_clip=False,
        )
    rejected = _failed(rows)[0] & (rows["step_norm"] > 0)
    if rejected.any():
        x, y = rows["iteration"][rejected], rows["step_norm"][rejected]
        axes.plot(x, y, "x", color=style.BEFORE, markersize=5)
    _end_at(axes, rows["iteration"][-1])
    axes.set_ylabel("gradient, step norm ‖δ‖, damping λ")
