"""A folder that shows one bundle adjustment: pictures, numbers, and a page that joins them."""

import html
import json
from dataclasses import dataclass
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
from raylign.viz.point_cloud import plot_point_cloud
from raylign.viz.residuals import plot_residuals
from raylign.viz.sparsity import plot_sparsity


@dataclass(frozen=True)
class _Picture:
    file: str
    title: str
    caption: str


_PICTURES = (
    _Picture(
        "point_cloud.png",
        "Reconstruction",
        "Points, cameras and viewing directions from above and from the side; same axes before and "
        "after, limits by percentiles.",
    ),
    _Picture(
        "cost.png",
        "Cost",
        "Cost of the held state against wall time and iterations, with rejected and invalid steps; "
        "gradient, step and damping.",
    ),
    _Picture(
        "residuals.png",
        "Residuals",
        "Norms of all residuals and RMSE of each camera, before and after; with a robust loss also "
        "the median of each camera, which outliers do not move.",
    ),
    _Picture(
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
        "index.html": _html_page(title, rows),
        "index.md": _markdown_page(title, rows),
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


_CSS = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2937; max-width: 1180px; margin: 2rem auto;
       padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; }
td { padding: .25rem 1rem .25rem 0; border-bottom: 1px solid #e5e7eb; vertical-align: top; }
td:first-child { color: #6b7280; white-space: nowrap; }
img { max-width: 100%; border: 1px solid #e5e7eb; }
figcaption { color: #6b7280; } figure { margin: 0 0 2rem 0; }
"""


def _html_page(title: str, rows: list[tuple[str, str]]) -> str:
    cells = "\n".join(
        f"<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>"
        for name, value in rows
    )
    pictures = "\n".join(
        f"<h2>{html.escape(p.title)}</h2>\n"
        f'<figure><img src="{p.file}" alt="{html.escape(p.title)}">'
        f"<figcaption>{html.escape(p.caption)}</figcaption></figure>"
        for p in _PICTURES
    )
    return (
        f'<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{_CSS}</style></head>\n<body>\n"
        f"<h1>{html.escape(title)}</h1>\n<table>\n{cells}\n</table>\n{pictures}\n"
        f'<p>All numbers: <a href="summary.json">summary.json</a></p>\n</body>\n</html>\n'
    )


def _markdown_page(title: str, rows: list[tuple[str, str]]) -> str:
    table = "\n".join(f"| {name} | {value.replace('|', chr(92) + '|')} |" for name, value in rows)
    pictures = "\n\n".join(
        f"## {p.title}\n\n![{p.title}]({p.file})\n\n{p.caption}" for p in _PICTURES
    )
    return (
        f"# {title}\n\n| | |\n| --- | --- |\n{table}\n\n{pictures}\n\n"
        "All numbers: [summary.json](summary.json)\n"
    )
