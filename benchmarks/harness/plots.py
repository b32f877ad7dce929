"""Figures from a results file, for docs/images."""

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from harness import series

COLORS = {
    "native": "#b5179e",
    "analytic": "#1d3557",
    "autodiff": "#4895ef",
    "pycolmap": "#f3722c",
    "gtsam": "#6a994e",
}
KINDS = {"street": "street loops", "orbit": "orbits"}
STYLE = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "savefig.dpi": 150,
}


def save_all(held: list[dict], folder: Path) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE):
        figures = {
            "benchmark-time.png": over_sizes(
                held, "s to 0.1 % above the best cost", lambda row: row["times_to"][-1], 1
            ),
            "benchmark-memory.png": over_sizes(
                held, "peak memory beyond the imports, MB", lambda row: row["memory_bytes"] / 1e6, 1
            ),
            "benchmark-growth.png": growth(held),
        }
        for name, figure in figures.items():
            figure.savefig(folder / name, bbox_inches="tight")
            plt.close(figure)
    return [folder / name for name in figures]


def over_sizes(
    held: list[dict], label: str, value: Callable[[dict], float], threads: int
) -> plt.Figure:
    """One panel per kind of scene, one line per system: its variant that is fastest there."""
    figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.8), sharey=True, layout="constrained")
    for panel, (kind, name) in zip(panels, KINDS.items(), strict=True):
        contests = series.by_size(held, kind)
        for family, color in COLORS.items():
            rows = [(c["num_observations"], series.row_of(c, family, threads)) for c in contests]
            xy = np.array([(n, value(row)) for n, row in rows if row is not None]).reshape(-1, 2)
            if len(xy) == 0:
                continue
            width = 2.4 if family == "native" else 1.4
            panel.plot(*xy.T, "o-", ms=4, lw=width, color=color, label=series.label(held, family))
        panel.set(xscale="log", yscale="log", xlabel="observations", title=name)
    panels[0].set_ylabel(label)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def growth(held: list[dict]) -> plt.Figure:
    """Seconds per iteration of the native engine, and the power of the size they grow with."""
    figure, panel = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
    for kind, marker in zip(KINDS, "os", strict=True):
        for threads, color in ((1, COLORS["native"]), (2, "#f3722c")):
            pairs = series.seconds_per_iteration(held, kind, threads)
            if len(pairs) < 2:
                continue
            slope = series.growth_exponent(pairs[pairs[:, 0] >= 30_000])
            label = f"{KINDS[kind]}, {threads} thread{'s' * (threads > 1)}: N$^{{{slope:.2f}}}$"
            panel.plot(*pairs.T, marker + "-", ms=4, lw=1.6, color=color, label=label)
    low, high = panel.get_xlim()
    ends = np.array([low, high])
    panel.plot(ends, 2e-7 * ends, "k:", lw=1, label="200 ns per observation")
    panel.set(xscale="log", yscale="log", xlabel="observations")
    panel.set_ylabel("s per Levenberg-Marquardt iteration, native engine")
    panel.legend()
    return figure
