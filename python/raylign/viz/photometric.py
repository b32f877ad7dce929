"""Photometric bundle adjustment in pictures: points by error, patches, the law of the residuals."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator

from raylign._typing import F64, AnyArray, PathLike
from raylign.errors import ShapeError
from raylign.photometric import EdgeStatus, LossScope, PhotometricResult
from raylign.photometric._views import counted, residual_scales, view_values
from raylign.viz import style

Canvas = Figure | SubFigure

_MAX_IMAGES = 8  # shown; of more, evenly chosen
_GROUPS = (("worst", 0.98), ("median", 0.5), ("best", 0.02))
_PER_GROUP = 5
_MAX_EDGES = 20_000  # whose residuals are drawn


@style.styled
def plot_points_by_error(result: PhotometricResult) -> Figure:
    """Draw each image with its points, coloured by their RMS residual before and after.

    Args:
        result: of `raylign.photometric.adjust`.

    Returns:
        Figure with two rows; at most eight images, evenly chosen.
    """
    shown = min(_MAX_IMAGES, result.problem.num_images)
    figure = style.new_figure(2.6 * shown + 1.2, 4.9, "Residual of each point", _size(result))
    _points_by_error(figure, result)
    return figure


def _points_by_error(figure: Canvas, result: PhotometricResult) -> None:
    problem = result.problem
    num = min(_MAX_IMAGES, problem.num_images)
    chosen = np.unique(np.linspace(0, problem.num_images - 1, num).round().astype(int))
    ok = result.edge_status == EdgeStatus.OK.value
    before, after = result.edge_rms_before, result.edge_rms_after
    high = float(np.nanpercentile(before[ok], 95)) if ok.any() else 1.0
    grid = figure.subplots(2, len(chosen), squeeze=False)
    for column, i in enumerate(chosen):
        mine = ok & (result.edge_image == i)
        for row, (rms, T_cw, points, name) in enumerate(
            (
                (before, problem.T_cw, problem.points, "before"),
                (after, result.T_cw, result.points, "after"),
            )
        ):
            axes = grid[row, column]
            image = problem.image(i)
            axes.imshow(image, cmap="gray", vmin=0, vmax=255, alpha=0.55)
            uv, _ = problem.project(i, T_cw=T_cw, points=points)
            at, value = uv[result.edge_point[mine]], rms[mine]
            order = np.argsort(value)
            dots = axes.scatter(
                *at[order].T, c=value[order], s=3.0, cmap="inferno", vmin=0, vmax=high, linewidths=0
            )
            axes.set_xlim(-0.5, image.shape[1] - 0.5)
            axes.set_ylim(image.shape[0] - 0.5, -0.5)
            axes.set_axis_off()
            median = f"{np.nanmedian(value):.1f}" if len(value) else "none"
            axes.set_title(f"{i} {name}: median {median}", fontsize=8)
    bar = figure.colorbar(dots, ax=grid, shrink=0.8, aspect=30, pad=0.01)
    bar.set_label("RMS residual of a view [grey levels]")


@style.styled
def plot_patches(result: PhotometricResult) -> Figure:
    """Draw patches: the reference, what an image shows in its place before and after.

    Args:
        result: of `raylign.photometric.adjust`.

    Returns:
        Figure with the worst (98 % quantile of the residual after), median and best (2 %) views.
    """
    figure = style.new_figure(9.6, 3.1, "Patches", "reference | image before | image after")
    _patches(figure, result)
    return figure


def _patches(figure: Canvas, result: PhotometricResult) -> None:
    edges, names = _chosen_views(result)
    reference = result.patches[result.edge_point[edges]]
    start, end = view_values(result, edges, start=True), view_values(result, edges)
    columns = np.stack([reference, start, end], axis=1)
    grid = figure.subplots(len(_GROUPS), _PER_GROUP, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for axes, views, edge, name in zip(grid.flat, columns, edges, names, strict=False):
        picture = _side_by_side(result, views)
        known = views[np.isfinite(views)]
        low, high = np.percentile(known, [0, 100]) if len(known) else (0.0, 255.0)
        axes.imshow(picture, cmap="gray", vmin=low, vmax=high, interpolation="nearest")
        rms = result.edge_rms_before[edge], result.edge_rms_after[edge]
        axes.set_title(f"{name}: {rms[0]:.1f} → {rms[1]:.1f}", fontsize=8)


def _chosen_views(result: PhotometricResult) -> tuple[AnyArray, list[str]]:
    """Views at three quantiles of the residual after, of different points."""
    rms = result.edge_rms_after
    foreign = result.edge_image != result.hosts[result.edge_point]
    usable = np.flatnonzero((result.edge_status == EdgeStatus.OK.value) & foreign & (rms >= 0))
    if len(usable) == 0:
        raise ShapeError("no view is in use: there is nothing to draw")
    order = usable[np.argsort(rms[usable], kind="stable")]
    chosen: list[int] = []
    names: list[str] = []
    for name, quantile in _GROUPS:
        middle = round(quantile * (len(order) - 1))
        first = min(max(0, middle - _PER_GROUP // 2), max(0, len(order) - _PER_GROUP))
        group = order[first : first + _PER_GROUP]
        chosen += group.tolist()
        names += [name] * len(group)
    return np.array(chosen), names


def _side_by_side(result: PhotometricResult, views: F64) -> F64:
    """Patches next to each other, a gap between them; any pattern on its own raster."""
    offsets = np.rint(result.options.pattern.offsets).astype(int)
    low = offsets.min(axis=0)
    width, height = offsets.max(axis=0) - low + 1
    picture = np.full((height, (width + 1) * len(views) - 1), np.nan)
    for k, values in enumerate(views):
        picture[offsets[:, 1] - low[1], offsets[:, 0] - low[0] + k * (width + 1)] = values
    return picture


@style.styled
def plot_law(result: PhotometricResult) -> Figure:
    """Draw the distribution of the residuals, the fitted law and the loss' threshold.

    Args:
        result: of `raylign.photometric.adjust`.

    Returns:
        Figure with a linear and a logarithmic panel; the image a patch was read from is left out.
    """
    figure = style.new_figure(9.6, 3.6, "Residuals of the pixels", _law_text(result))
    _law(figure, result)
    return figure


def _law(figure: Canvas, result: PhotometricResult) -> None:
    residuals = pixel_residuals(result)
    per_pixel = result.options.noise.scope is LossScope.PIXEL
    dashed = "; dashed: scale of the loss" if per_pixel else ""
    panels = figure.subplots(1, 2)
    reach = max(4.0 * float(np.median(np.abs(residuals))) / 0.6745, 1.0)
    for axes, limit in ((panels[0], reach), (panels[1], 5.0 * reach)):
        bins = np.linspace(-limit, limit, 121)
        axes.hist(
            residuals, bins.tolist(), density=True, color=style.AFTER, alpha=0.45, label="residuals"
        )
        inside = float(np.mean(np.abs(residuals) <= limit))  # the histogram's density is of these
        for name, density, color in _densities(result, bins):
            axes.plot(bins, density / max(inside, 1e-9), color=color, label=name)
        if per_pixel and 0.0 < result.threshold < limit:
            for x in (-result.threshold, result.threshold):
                axes.axvline(x, color=style.MUTED, linewidth=0.9, linestyle="--")
        axes.set_xlim(-limit, limit)
        axes.set_xlabel("residual [grey levels]" + dashed)
        axes.set_ylabel("density")
    panels[1].set_yscale("log")
    top = panels[0].get_ylim()[1]
    panels[1].set_ylim(1e-4 * top, 1.5 * top)
    panels[1].legend(loc="upper right", fontsize=7.5)


def pixel_residuals(result: PhotometricResult) -> F64:
    """Residuals of the pixels that count, of views in use but the hosts' own, grey levels."""
    foreign = result.edge_image != result.hosts[result.edge_point]
    edges = np.flatnonzero((result.edge_status == EdgeStatus.OK.value) & foreign)
    if len(edges) > _MAX_EDGES:
        edges = edges[np.linspace(0, len(edges) - 1, _MAX_EDGES).astype(int)]
    r = result.patches[result.edge_point[edges]] - view_values(result, edges)
    r *= residual_scales(result, edges)[:, None]
    r = r[counted(result, edges) & np.isfinite(r)]
    if len(r) == 0:
        raise ShapeError("no view is in use: there are no residuals")
    return np.asarray(r, np.float64)


def _densities(result: PhotometricResult, x: AnyArray) -> list[tuple[str, F64, str]]:
    sigma, nu = float(result.sigma), float(result.nu)
    curves = []
    if nu > 0.0 and result.threshold > 0.0:
        scale = float(result.threshold)
        log_norm = math.lgamma((nu + 1) / 2) - math.lgamma(nu / 2) - 0.5 * math.log(nu * math.pi)
        shape = -(nu + 1) / 2 * np.log1p((x / scale) ** 2 / nu)
        density = np.exp(log_norm + shape) / scale
        curves.append((f"Student t, ν {nu:.3g}, scale {scale:.3g}", density, style.BEFORE))
    if sigma > 0.0:
        normal = np.exp(-0.5 * (x / sigma) ** 2) / (sigma * math.sqrt(2 * math.pi))
        curves.append((f"N(0, {sigma:.3g}²)", normal, style.ACCENT))
    return curves


def _law_text(result: PhotometricResult) -> str:
    text = f"σ {result.sigma:.3g} grey levels" if result.sigma > 0 else "fixed loss"
    return text + (f", ν {result.nu:.3g}" if result.nu > 0 else "")


@style.styled
def plot_images(result: PhotometricResult) -> Figure:
    """Draw what happened to each image: shift, residual before and after, brightness.

    Args:
        result: of `raylign.photometric.adjust`.

    Returns:
        Figure with four panels over the images.
    """
    figure = style.new_figure(13.5, 3.4, "Images", _size(result))
    shift, residual, gain, offset = figure.subplots(1, 4)
    x = np.arange(result.problem.num_images)
    shift.bar(x, np.nan_to_num(result.shift_px), color=style.AFTER, width=0.6)
    shift.set_ylabel("median motion of the points [px]")
    for rms, color, name in (
        (result.edge_rms_before, style.BEFORE, "before"),
        (result.edge_rms_after, style.AFTER, "after"),
    ):
        residual.plot(x, _image_medians(result, rms), "o", color=color, label=name)
    residual.set_ylim(bottom=0.0)
    residual.set_ylabel("median RMS residual of a view [grey]")
    residual.legend()
    gain.plot(x, np.exp(result.brightness[:, 0]), "o", color=style.AFTER)
    gain.set_ylabel("gain $e^a$")
    offset.plot(x, result.brightness[:, 1], "o", color=style.AFTER)
    offset.set_ylabel("offset b [grey levels]")
    for axes, neutral in ((gain, 1.0), (offset, 0.0)):
        axes.axhline(neutral, color=style.MUTED, linewidth=0.8)
    for axes in (shift, residual, gain, offset):
        axes.set_xlabel("image")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


def _image_medians(result: PhotometricResult, rms: F64) -> list[float]:
    """Of the views in use; NaN for an image without any."""
    ok = (result.edge_status == EdgeStatus.OK.value) & np.isfinite(rms)
    images = range(result.problem.num_images)
    parts = [rms[ok & (result.edge_image == i)] for i in images]
    return [float(np.median(part)) if len(part) else float("nan") for part in parts]


@style.styled
def plot_rounds(result: PhotometricResult) -> Figure:
    """Draw the cost of every iteration, round by round.

    Args:
        result: of `raylign.photometric.adjust`.

    Returns:
        Figure with the cost over iterations and over time; each round has its own law and views, so
        that costs compare within a round only.

    Raises:
        ShapeError: there was no iteration.
    """
    rows = result.summary.iterations
    if len(rows) == 0:
        raise ShapeError("plot_rounds: the summary has no iterations")
    figure = style.new_figure(10.5, 3.8, "Cost", f"{len(result.rounds)} rounds")
    over_iterations, over_time = figure.subplots(1, 2)
    for axes, x, label in (
        (over_iterations, rows["iteration"], "iteration"),
        (over_time, rows["cumulative_time_s"], "wall time [s]"),
    ):
        _round_curves(axes, result, x, rows)
        axes.set_xlabel(label)
        axes.set_ylabel("cost ½ Σ ρ [grey²]")
        style.log_axis(axes, rows["cost"])
    over_iterations.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


def _round_curves(axes: Axes, result: PhotometricResult, x: AnyArray, rows: AnyArray) -> None:
    colors = [style.AFTER, style.ACCENT, style.BEFORE, style.CAMERA, style.MUTED]
    seen: set[int] = set()
    first = 0  # row of the state that the round starts from
    for row in result.rounds:
        level, last = int(row["level"]), first + int(row["num_iterations"])
        cost = np.append(row["initial_cost"], rows["cost"][first + 1 : last + 1])
        label = None if level in seen else f"level {level}"
        axes.plot(
            x[first : last + 1],
            np.minimum.accumulate(cost),
            "-o",
            color=colors[level % len(colors)],
            markersize=2.5,
            label=label,
        )
        seen.add(level)
        first = last
    axes.legend()


def write_before_after(result: PhotometricResult, path: PathLike) -> None:
    """Write one picture: points by error in the images, patches, and the residuals' law."""
    shown = min(_MAX_IMAGES, result.problem.num_images)
    import matplotlib as mpl

    with mpl.rc_context(style.RC):
        figure = style.new_figure(
            2.4 * shown + 1.2, 12.0, "Before and after", result.brief_report()
        )
        parts = figure.subfigures(3, 1, height_ratios=(1.25, 1.0, 0.85), squeeze=False)
        for part, draw in zip(parts.flat, (_points_by_error, _patches, _law), strict=True):
            draw(part, result)
        figure.savefig(path, dpi=style.DPI)


def _size(result: PhotometricResult) -> str:
    ok = int(np.count_nonzero(result.edge_status == EdgeStatus.OK.value))
    return (
        f"{result.problem.num_images} images, {style.count(result.problem.num_points)} points, "
        f"{style.count(ok)} views in use"
    )
