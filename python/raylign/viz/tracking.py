"""How well frames agree with their keyframes: residual maps, statistics, time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from raylign._typing import F64, AnyArray
from raylign.odometry import OdometryResult, OdometryRun, OdometryStatus, has_pose
from raylign.tracking import AlignmentResult
from raylign.trajectory import Trajectory
from raylign.viz import style
from raylign.viz.trajectory import with_breaks

_STATUS_COLORS = {
    OdometryStatus.OK: style.AFTER,
    OdometryStatus.RECOVERED: style.ACCENT,
    OdometryStatus.LOST: style.BEFORE,
    OdometryStatus.NO_DEPTH: style.MUTED,
}
_N_RANGE = 5.0  # of the normalised residual, standard deviations


@style.styled
def plot_alignment(image: AnyArray, result: AlignmentResult, *, title: str = "") -> Figure:
    """Draw an alignment: the target, the residual, σ_r and the weight, at the keyframe's pixels.

    Args:
        image: (H, W) or (H, W, 3) of the target.
        result: with maps (`align(…, maps=True)`).
        title: of the figure.

    Returns:
        Figure with four panels; pixels without a point are grey.
    """
    maps: Any = result.maps  # an object in the stub: None without maps
    figure = style.new_figure(13.5, 3.3, title or "Alignment", _status_text(result))
    panels = figure.subplots(1, 4)
    panels[0].imshow(image, cmap="gray", vmin=0, vmax=255)
    panels[0].set_title("target")
    for axes, values, name, color_map, limits in (
        (panels[1], maps.residual, "residual r, grey levels", "RdBu_r", (-40.0, 40.0)),
        (panels[2], maps.sigma, "σ_r, grey levels", "magma", (0.0, None)),
        (panels[3], maps.weight, "Huber weight", "viridis", (0.0, 1.0)),
    ):
        _map(figure, axes, values, name, color_map, limits)
    for axes in panels:
        axes.set_axis_off()
    return figure


def _map(
    figure: Figure,
    axes: Axes,
    values: AnyArray,
    name: str,
    color_map: str,
    limits: tuple[float, float | None],
) -> None:
    axes.set_facecolor("#d1d5db")
    axes.imshow(np.full(values.shape, 0.82), cmap="gray", vmin=0, vmax=1)
    picture = axes.imshow(values, cmap=color_map, vmin=limits[0], vmax=limits[1])
    axes.set_title(name)
    figure.colorbar(picture, ax=axes, shrink=0.8)


def _status_text(result: AlignmentResult) -> str:
    text = f"{result.status.name}, {result.num_points} points, {result.overlap:.0%} in view"
    return text + (f": {result.reason}" if result.reason else "")


@style.styled
def plot_normalised_residuals(n: AnyArray, *, subtitle: str = "") -> Figure:
    """Draw the distribution of normalised residuals r / σ_r beside N(0, 1).

    Args:
        n: normalised residuals, any shape; NaN is left out.
        subtitle: where they come from.

    Returns:
        Figure with a histogram (density) and quantiles against those of N(0, 1).
    """
    values = np.asarray(n, np.float64).ravel()
    values = values[np.isfinite(values)]
    spread = values.std() if len(values) else float("nan")
    figure = style.new_figure(9.0, 3.6, "Normalised residual r / σ_r", subtitle)
    left, right = figure.subplots(1, 2)
    x = np.linspace(-_N_RANGE, _N_RANGE, 201)
    left.hist(np.clip(values, -_N_RANGE, _N_RANGE), bins=101, density=True, color=style.AFTER)
    left.plot(x, np.exp(-x * x / 2) / np.sqrt(2 * np.pi), color=style.CAMERA, label="N(0, 1)")
    left.set(xlabel="r / σ_r", ylabel="density", title=f"standard deviation {spread:.2f}")
    left.legend()
    _quantiles(right, values)
    return figure


def _quantiles(axes: Axes, values: F64) -> None:
    from statistics import NormalDist

    shares = np.linspace(0.005, 0.995, 199)
    normal = [NormalDist().inv_cdf(share) for share in shares]
    if len(values):
        axes.plot(normal, np.quantile(values, shares), color=style.AFTER)
    axes.plot(normal, normal, color=style.CAMERA, linewidth=0.8)
    axes.set(xlabel="quantile of N(0, 1)", ylabel="quantile of r / σ_r", title="quantiles")


@style.styled
def plot_path(trajectory: Trajectory, *, title: str = "Path") -> Figure:
    """Draw a path that has no truth to be compared with.

    Args:
        trajectory: at least one pose; the first camera's frame is the world: x right, y down.
        title: of the figure.

    Returns:
        Figure with two panels, from above (x, z) and from the side (z, y), in m.
    """
    points = with_breaks(trajectory)
    figure = style.new_figure(11.0, 4.6, title, f"{trajectory.path_length():.4g} m")
    above, side = figure.subplots(1, 2)
    for axes, (a, b), name in ((above, (0, 2), "from above"), (side, (2, 1), "from the side")):
        axes.plot(points[:, a], points[:, b], color=style.AFTER)
        axes.plot(points[0, a], points[0, b], "o", color=style.CAMERA, markersize=5)
        axes.set(xlabel=f"{'xyz'[a]} [m]", ylabel=f"{'xyz'[b]} [m]", title=name)
        axes.set_aspect("equal", adjustable="datalim")
    side.invert_yaxis()
    return figure


@style.styled
def plot_run(run: OdometryRun, *, subtitle: str = "") -> Figure:
    """Draw what a run says of each frame: status, share of points in view, agreement, time.

    Args:
        run: of `raylign.odometry.run`.
        subtitle: name of the sequence.

    Returns:
        Figure with three panels over the frame number; keyframes are marked.
    """
    figure = style.new_figure(11.0, 6.6, "Tracking", subtitle)
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    frames = np.array([r.frame for r in run.results])
    _agreement(top, frames, run.results)
    _residuals(middle, frames, run.results)
    _times(bottom, frames, run)
    bottom.set_xlabel("frame")
    return figure


def _agreement(axes: Axes, frames: AnyArray, results: tuple[OdometryResult, ...]) -> None:
    for name, color in (("usage", style.AFTER), ("good_ratio", style.ACCENT)):
        values = [getattr(r.alignment, name) if has_pose(r) else np.nan for r in results]
        axes.plot(frames, values, color=color, label=name.replace("_", " "))
    for result in results:
        if result.status is not OdometryStatus.OK:
            axes.axvline(result.frame, color=_STATUS_COLORS[result.status], alpha=0.5)
    _mark_keyframes(axes, results)
    axes.set(ylim=(0.0, 1.05), ylabel="share of points")
    axes.legend(loc="lower left", ncols=3)


def _mark_keyframes(axes: Axes, results: tuple[OdometryResult, ...]) -> None:
    keyframes = [r.frame for r in results if r.is_keyframe]
    axes.plot(keyframes, np.full(len(keyframes), 1.02), "v", color=style.CAMERA, label="keyframe")


def _residuals(axes: Axes, frames: AnyArray, results: tuple[OdometryResult, ...]) -> None:
    values = np.array([r.alignment.residual_variance if has_pose(r) else np.nan for r in results])
    values[values < 0] = np.nan  # the first frame is not aligned with anything
    axes.plot(frames, np.sqrt(values), color=style.AFTER)
    axes.axhline(1.0, color=style.CAMERA, linewidth=0.8)
    axes.set(ylabel="robust RMS of r / σ_r")
    axes.set_ylim(bottom=0.0)


def _times(axes: Axes, frames: AnyArray, run: OdometryRun) -> None:
    milliseconds = 1e3 * run.times_s
    axes.plot(frames, milliseconds, ".", markersize=3, color=style.AFTER)
    median, p95 = np.percentile(milliseconds, [50, 95]) if len(milliseconds) else (np.nan, np.nan)
    axes.axhline(median, color=style.CAMERA, linewidth=0.8)
    axes.set(ylabel="time, ms", title=f"median {median:.2f} ms, 95 % under {p95:.2f} ms")
    axes.set_ylim(bottom=0.0)
