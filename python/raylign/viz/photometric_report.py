"""A folder that shows one photometric bundle adjustment."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from raylign._build_info import build_info
from raylign._json import jsonable
from raylign._typing import PathLike
from raylign.photometric import PhotometricResult
from raylign.photometric._result import cameras_as_bal
from raylign.viz import photometric as draw
from raylign.viz import style
from raylign.viz.page import Picture, html_page, markdown_page
from raylign.viz.point_cloud import plot_point_cloud

_POINTS = Picture(
    "points_by_error.png",
    "Points",
    "Points in the images by their RMS residual, before and after; only views in use.",
)
_PATCHES = Picture(
    "patches.png",
    "Patches",
    "Reference, and what an image shows in its place before and after: the worst 2 %, the median "
    "and the best 2 % of the views after; RMS residual before and after.",
)
_LAW = Picture(
    "residuals.png",
    "Residuals",
    "Residuals of all pixels in use, the fitted law, and a normal distribution of the same "
    "median; dashed the scale of the loss.",
)
_IMAGES = Picture(
    "images.png",
    "Images",
    "Median motion of the points, median residual, and the brightness e^a I + b that was found.",
)
_COST = Picture(
    "cost.png",
    "Cost",
    "Each round has its own views, warps and law: costs compare within a round. The last rounds "
    "include the points that were held out.",
)
_CLOUD = Picture(
    "point_cloud.png", "Point cloud", "Points and cameras from above and from the side."
)


def photometric_report(
    result: PhotometricResult,
    directory: PathLike,
    *,
    title: str = "Photometric bundle adjustment",
    pictures: bool = True,
) -> list[Path]:
    """Write before.ply, after.ply, summary.json, and with `pictures` PNGs, index.html, index.md.

    Args:
        result: of `raylign.photometric.adjust`.
        directory: folder to write into; created, with its parents, when missing.
        title: heading of the page.
        pictures: draw.

    Returns:
        Paths of the files written.

    Raises:
        OSError: the folder cannot be made or written.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / "before.ply", folder / "after.ply"]
    for path, start in zip(written, (True, False), strict=True):
        result.write_ply(path, start=start)
    pages = {"summary.json": _summary(result, title)}
    if pictures:
        drawn = _draw(result)
        listed = [picture for picture, _ in drawn]
        written += [style.save(figure, folder / picture.file) for picture, figure in drawn]
        rows = _headline(result)
        pages["index.html"] = html_page(title, rows, listed)
        pages["index.md"] = markdown_page(title, rows, listed)
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
        written.append(folder / name)
    return written


def _draw(result: PhotometricResult) -> list[tuple[Picture, Figure]]:
    problem = result.problem
    clouds = [
        cameras_as_bal(problem, T_cw, points).replace(colors=result.point_colors())
        for T_cw, points in (
            (problem.T_cw, problem.points),
            (result.T_cw, result.points),
        )
    ]
    sizes = f"{problem.num_images} cameras, {style.count(problem.num_points)} points"
    drawn = [
        (_IMAGES, draw.plot_images(result)),
        (_CLOUD, plot_point_cloud(*clouds, subtitle=sizes)),
    ]
    if len(result.summary.iterations):
        drawn.insert(0, (_COST, draw.plot_rounds(result)))
    if result.edge_counts().get("ok", 0):
        drawn[:0] = [
            (_POINTS, draw.plot_points_by_error(result)),
            (_PATCHES, draw.plot_patches(result)),
            (_LAW, draw.plot_law(result)),
        ]
    return drawn


def _headline(result: PhotometricResult) -> list[tuple[str, str]]:
    before, after = result.residual_median()
    summary = result.summary
    points = ", ".join(f"{style.count(n)} {k}" for k, n in result.point_counts().items())
    views = ", ".join(f"{style.count(n)} {k}" for k, n in result.edge_counts().items())
    noise = f"σ {result.sigma:.3g} grey levels" + (f", ν {result.nu:.3g}" if result.nu > 0 else "")
    rows = [
        ("verdict", ("accepted: " if result.accepted else "NOT accepted: ") + result.reason),
        ("median RMS residual", f"{before:.3g} → {after:.3g} grey levels"),
        ("shift", f"median over the images {np.nanmedian(result.shift_px):.2f} px"),
        ("points", points),
        ("views", views),
        ("noise", f"{noise}; scale of the loss {result.threshold:.3g}"),
        ("gauge", result.gauge),
        ("termination", f"{summary.termination.name.lower()}: {summary.message}"),
        ("rounds", f"{len(result.rounds)}, {len(summary.iterations) - 1} iterations"),
        ("backend", f"{summary.backend}, {summary.num_threads} thread(s)"),
        ("time", f"{summary.total_time_s:.3f} s"),
    ]
    return rows + [("note", message) for message in result.messages]


def _summary(result: PhotometricResult, title: str) -> str:
    before, after = result.residual_median()
    images = [
        {
            "image": i,
            "shift_px": float(result.shift_px[i]),
            "rms_before": float(result.image_rms_before[i]),
            "rms_after": float(result.image_rms_after[i]),
            "a": float(result.brightness[i, 0]),
            "b": float(result.brightness[i, 1]),
            "T_cw": result.T_cw[i],
        }
        for i in range(result.problem.num_images)
    ]
    record: dict[str, Any] = {
        "title": title,
        "units": {"rms, sigma, threshold, b": "grey levels 0..255", "cost": "grey^2", "*_s": "s"},
        "accepted": result.accepted,
        "reason": result.reason,
        "messages": result.messages,
        "hold_out": {
            "num_points": result.num_hold_out,
            "cost_before": result.hold_out_cost_before,
            "cost_after": result.hold_out_cost_after,
        },
        "median_rms": {"before": before, "after": after},
        "points": result.point_counts(),
        "views": result.edge_counts(),
        "noise": {"sigma": result.sigma, "nu": result.nu, "threshold": result.threshold},
        "gauge": result.gauge,
        "intrinsics": result.intrinsics,
        "images": images,
        "rounds": result.rounds,
        "summary": result.summary,
        "options": result.options,
        "config": result.config,
        "build": build_info(),
    }
    return json.dumps(jsonable(record), indent=2, allow_nan=False) + "\n"
