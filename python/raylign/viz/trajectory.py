"""Paths against the truth, and errors over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from raylign._typing import F64
from raylign.errors import OptionsError
from raylign.trajectory import Evaluation, Trajectory
from raylign.viz import style

_AXES = "xyz"
_GAP = 5.0  # median periods without a pose break a drawn line


@style.styled
def plot_trajectory(evaluation: Evaluation, *, up: str = "", title: str = "Trajectory") -> Figure:
    """Draw the aligned estimate and the truth from above and from the side, and the errors.

    Args:
        evaluation: what `raylign.trajectory.evaluate` returned.
        up: `x`, `y` or `z`, the axis that points up or down; default: the one along which the
            truth is shortest.
        title: of the figure.

    Returns:
        Figure with four panels: from above, from the side, ATE over time, RPE per frame over time.

    Raises:
        OptionsError: `up` is no axis.
    """
    if up not in ("", *_AXES):
        raise OptionsError(f"up must be x, y or z, got {up!r}")
    estimate, truth = evaluation.absolute.estimate, evaluation.absolute.truth
    extent = np.ptp(truth.positions, axis=0)
    vertical = _AXES.index(up) if up else int(np.argmin(extent))
    first, second = sorted(
        (axis for axis in range(3) if axis != vertical), key=lambda axis: -extent[axis]
    )
    rmse = evaluation.absolute.translation.rmse
    subtitle = (
        f"{evaluation.num_matched} poses, {evaluation.path_length:.4g} m, aligned by "
        f"{evaluation.alignment.value}: ATE {rmse:.4g} m"
    )
    figure = style.new_figure(11.5, 8.0, title, subtitle)
    (above, side), (absolute, relative) = figure.subplots(2, 2, height_ratios=[1.7, 1.0])
    draw_paths(above, estimate, truth, (first, second))
    above.set_title("from above")
    draw_paths(side, estimate, truth, (first, vertical))
    side.set_title("from the side")
    draw_absolute_error(absolute, evaluation)
    draw_relative_error(relative, evaluation)
    style.legend_below(figure, above)
    return figure


def draw_paths(axes: Axes, estimate: Trajectory, truth: Trajectory, shown: tuple[int, int]) -> None:
    """Draw both paths in the plane of two axes (0 = x), at one scale."""
    for path, color, name in (
        (truth, style.MUTED, "truth"),
        (estimate, style.AFTER, "estimate"),
    ):
        points = with_breaks(path)
        axes.plot(points[:, shown[0]], points[:, shown[1]], color=color, label=name)
    start = truth.positions[0]
    axes.plot(
        start[shown[0]], start[shown[1]], "o", color=style.CAMERA, markersize=5, label="start"
    )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{_AXES[shown[0]]} [m]")
    axes.set_ylabel(f"{_AXES[shown[1]]} [m]")


def draw_absolute_error(axes: Axes, evaluation: Evaluation) -> None:
    """Draw the distance from the truth after alignment over time."""
    truth = evaluation.absolute.truth
    error = evaluation.absolute.translation
    time = truth.timestamps - truth.timestamps[0]
    axes.plot(time, error.values, color=style.BEFORE)
    axes.axhline(error.rmse, color=style.MUTED, linewidth=0.8, linestyle=":")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("distance from the truth [m]")
    axes.set_title(f"ATE: rmse {error.rmse:.4g} m (dotted), largest {error.max:.4g} m")


def draw_relative_error(axes: Axes, evaluation: Evaluation) -> None:
    """Draw the error of each step from frame to frame over time."""
    truth, error = evaluation.absolute.truth, evaluation.per_frame
    axes.set_xlabel("time [s]")
    axes.set_ylabel("translation [m]")
    if len(error.pairs) == 0:
        axes.set_title("RPE: one pose has no steps")
        return
    time = truth.timestamps[error.pairs[:, 1]] - truth.timestamps[0]
    axes.plot(time, error.translation.values, color=style.AFTER)
    axes.set_ylim(bottom=0.0)
    degrees = np.degrees(error.rotation.rmse)
    axes.set_title(f"RPE per frame: rmse {error.translation.rmse:.4g} m, {degrees:.4g}°")


def with_breaks(path: Trajectory) -> F64:
    """(M, 3) positions with a NaN row where poses are missing for long: the line stops there."""
    gaps = np.diff(path.timestamps)
    if len(gaps) == 0:
        return path.positions
    after = np.flatnonzero(gaps > _GAP * np.median(gaps)) + 1
    return np.asarray(np.insert(path.positions, after, np.nan, axis=0))
