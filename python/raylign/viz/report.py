"""A folder that shows one bundle adjustment: pictures, numbers, and a page that joins them."""

import json
from pathlib import Path
from typing import Any

from raylign._build_info import build_info
from raylign._json import jsonable
from raylign._typing import PathLike
from raylign.bundle import BundleConfig, BundleOptions, Summary
from raylign.robust import LossType
from raylign.scene import BalProblem, ProblemStatistics
from raylign.viz import style
from raylign.viz.cost import plot_cost
from raylign.viz.page import Picture, html_page, markdown_page
from raylign.viz.point_cloud import plot_point_cloud
from raylign.viz.residuals import plot_residuals
from raylign.viz.sparsity import plot_sparsity

_PICTURES = (
    Picture(
        "point_cloud.png",
        "Reconstruction",
        "Points, cameras and viewing directions from above and from the side; same axes before and "
        "after, limits by percentiles.",
    ),
    Picture(
        "cost.png",
        "Cost",
        "Cost of the held state against wall time and iterations, with rejected and invalid steps; "
        "gradient, step and damping.",
    ),
    Picture(
        "residuals.png",
        "Residuals",
        "Norms of all residuals and RMSE of each camera, before and after; with a robust loss also "
        "the median of each camera, which outliers do not move.",
    ),
    Picture(
        "sparsity.png",
        "Sparsity",
        "Blocks of the Jacobian J, of H = JᵀJ, and of the reduced camera matrix S that is left "
        "when the points are eliminated.",
    ),
)


def bundle_report(
    before: BalProblem,
    after: BalProblem,
    summary: Summary,
    directory: PathLike,
    *,
    options: BundleOptions | None = None,
    config: BundleConfig | None = None,
    title: str = "Bundle adjustment",
    extra: dict[str, Any] | None = None,
) -> list[Path]:
    """Write four PNGs, `summary.json`, `index.html` and `index.md` into a folder.

    Args:
        before: the problem before the solve.
        after: the refined problem.
        summary: of the solve.
        directory: folder to write into; created, with its parents, when missing.
        options: what the solve ran with, for the record.
        config: what it held fixed, for the record.
        title: heading of the page.
        extra: further entries of `summary.json`, e.g. errors against a known truth.

    Returns:
        Paths of the files written, pictures first.

    Raises:
        OSError: the folder cannot be made or written.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    statistics = (before.statistics(), after.statistics())
    robust = options is not None and options.loss.type is not LossType.TRIVIAL
    figures = (
        plot_point_cloud(before, after),
        plot_cost(summary, subtitle=style.size_text(before)),
        plot_residuals(before, after, median=robust),
        plot_sparsity(after),
    )
    written = [
        style.save(figure, folder / picture.file)
        for figure, picture in zip(figures, _PICTURES, strict=True)
    ]
    record = {
        "title": title,
        "units": _UNITS,
        "summary": summary,
        "options": options,
        "config": config,
        "problem": dict(zip(("before", "after"), statistics, strict=True)),
        **(extra or {}),
        "build": build_info(),
    }
    rows = _headline(before, after, summary, statistics)
    pages = {
        "summary.json": json.dumps(jsonable(record), indent=2, allow_nan=False) + "\n",
        "index.html": html_page(title, rows, _PICTURES),
        "index.md": markdown_page(title, rows, _PICTURES),
    }
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
        written.append(folder / name)
    return written


_UNITS = {
    "summary.*cost*": "px^2: half the sum of rho(||r||^2), the robust cost that was minimised",
    "problem.*.cost": "px^2: half the sum of ||r||^2, plain squares whatever the loss",
    "problem.*.rmse": "px per coordinate, plain squares",
    "problem.*.median_error, max_error": "px, norm ||r||",
    "*_time_s": "s",
}


def _headline(
    before: BalProblem,
    after: BalProblem,
    summary: Summary,
    statistics: tuple[ProblemStatistics, ProblemStatistics],
) -> list[tuple[str, str]]:
    old, new = statistics
    return [
        ("problem", style.size_text(before)),
        ("termination", f"{summary.termination.name.lower()}: {summary.message}"),
        ("cost ½ Σ ρ(‖r‖²)", f"{summary.initial_cost:.8g} → {summary.final_cost:.8g} px²"),
        ("RMSE", f"{old.rmse:.4g} → {new.rmse:.4g} px per coordinate"),
        ("median ‖r‖", f"{old.median_error:.4g} → {new.median_error:.4g} px"),
        (
            "points behind their camera",
            f"{old.num_behind_camera} → {new.num_behind_camera} of {after.num_observations} "
            "observations",
        ),
        ("steps", f"{summary.num_accepted} accepted, {summary.num_rejected} rejected"),
        (
            "linear solver",
            f"{summary.linear_solver.name.lower()} ({summary.linear_solver_reason})",
        ),
        ("backend", f"{summary.backend}, {summary.num_threads} thread(s)"),
        ("time", f"{summary.total_time_s:.3f} s"),
    ]
