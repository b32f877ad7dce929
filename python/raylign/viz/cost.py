"""Cost against time and against iterations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from raylign._typing import F64, AnyArray, Bool
from raylign.bundle import Summary
from raylign.viz import style


@style.styled
def plot_cost(summary: Summary, *, subtitle: str = "") -> Figure:
    """Draw how the cost fell: against wall time, against iterations, and what the solver saw.

    Args:
        summary: of a solve; needs at least its row 0.
        subtitle: problem size, for the title.

    Returns:
        Figure with three panels: cost over seconds, cost over iterations (rejected steps crossed),
        gradient, step and damping over iterations.
    """
    rows = summary.iterations
    best = _best_cost(rows)
    rejected = np.asarray(~rows["step_is_accepted"] & (rows["iteration"] > 0))
    figure = style.new_figure(13.5, 4.4, "Cost", subtitle)
    over_time, over_iterations, state = figure.subplots(1, 3)

    _cost_curve(over_time, rows["cumulative_time_s"], best, rejected)
    over_time.set_xlabel("wall time [s]")
    over_time.set_xlim(left=0)
    over_time.set_title("cost against time")

    _cost_curve(over_iterations, rows["iteration"], best, rejected)
    above = best - best[-1]
    if (above > 0).any():
        x = rows["iteration"][above > 0]
        style_above = {"color": style.ACCENT, "markersize": 2.0, "linewidth": 1.2}
        over_iterations.plot(x, above[above > 0], "-o", label="cost above the final", **style_above)
    over_iterations.set_xlabel("iteration")
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


def _cost_curve(axes: Axes, x: AnyArray, cost: F64, rejected: Bool) -> None:
    marker = 3.5 if len(cost) <= 80 else 2.0
    axes.plot(x, cost, "-o", color=style.AFTER, markersize=marker, label="cost ½ Σ ρ(‖r‖²)")
    if rejected.any():
        axes.plot(x[rejected], cost[rejected], "x", color=style.BEFORE, label="rejected step")
    axes.axhline(cost[-1], color=style.MUTED, linewidth=0.8, linestyle=":", label="final cost")
    axes.set_ylabel("cost [px²]")
    style.log_axis(axes, cost)


def _state_curves(axes: Axes, rows: AnyArray) -> None:
    curves = (
        ("gradient_max_norm", style.AFTER, "max |g|"),
        ("step_norm", style.ACCENT, "‖δ‖"),
        ("lambda", style.BEFORE, "λ"),
    )
    axes.set_yscale("log")
    for field, color, symbol in curves:
        keep = rows[field] > 0
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
    axes.margins(x=0.1)
    axes.set_ylabel("gradient, step norm ‖δ‖, damping λ")
