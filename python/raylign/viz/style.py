"""One look for every figure: sizes, colours, titles."""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, Protocol, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from raylign._typing import F64
from raylign.errors import ShapeError
from raylign.scene import BalProblem

BEFORE = "#c8553d"  # red clay
AFTER = "#1f7a8c"  # teal
CAMERA = "#101820"
ACCENT = "#e0a030"  # amber
MUTED = "#6b7280"
HEIGHT_COLORMAP = "viridis"
DPI = 150

RC: Any = {  # typed by matplotlib as a dict of literals
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.edgecolor": "#9ca3af",
    "axes.linewidth": 0.8,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e7eb",
    "grid.linewidth": 0.7,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.color": "#4b5563",
    "ytick.color": "#4b5563",
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "figure.facecolor": "white",
    "savefig.dpi": DPI,
}

P = ParamSpec("P")
R = TypeVar("R")


class _Sized(Protocol):
    @property
    def num_cameras(self) -> int: ...
    @property
    def num_points(self) -> int: ...
    @property
    def num_observations(self) -> int: ...


def require_content(function: str, *problems: BalProblem) -> None:
    """Raise ShapeError for a problem that has no camera or no point: there is nothing to draw."""
    for problem in problems:
        if problem.num_cameras == 0 or problem.num_points == 0:
            raise ShapeError(
                f"{function}: nothing to draw, the problem has {problem.num_cameras} cameras and "
                f"{problem.num_points} points"
            )


def styled(function: Callable[P, R]) -> Callable[P, R]:
    """Run a plot function under the house style; the caller's settings stay untouched."""

    @functools.wraps(function)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        with mpl.rc_context(RC):
            return function(*args, **kwargs)

    return wrapper


def new_figure(width: float, height: float, title: str, subtitle: str = "") -> Figure:
    """Return an empty titled figure (inches); not known to pyplot, so nothing needs closing."""
    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.08, h_pad=0.08)  # type: ignore[union-attr, call-arg]
    text = title if not subtitle else f"{title}  ·  {subtitle}"
    figure.suptitle(text, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
    return figure


def legend_below(figure: Figure, axes: Axes) -> None:
    """Put the entries of one axes in a row under the whole figure, where no data can be."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=max(1, len(labels)))


def log_axis(axes: Axes, values: F64) -> None:
    """Logarithmic y axis with labels at decades, or also at 2 and 5 where it spans less than two.

    `values`: everything drawn in the axes.
    """
    positive = values[np.isfinite(values) & (values > 0)]
    if len(positive) == 0:
        return
    axes.set_yscale("log")
    narrow = positive.max() / positive.min() < 100
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if narrow else (1.0,)))
    if narrow:
        axes.yaxis.set_major_formatter(FuncFormatter(plain_number))
    axes.yaxis.set_minor_formatter(NullFormatter())


def plain_number(value: float, _position: int | None = None) -> str:
    """Tick label without powers of ten where six digits suffice."""
    return f"{value:g}"


@styled
def save(figure: Figure, path: Path) -> Path:
    """Write a PNG and return its path."""
    figure.savefig(path, dpi=DPI, metadata={"Software": "raylign"})
    return path


def count(number: int) -> str:
    """Thousands apart by a thin space: 31843 → 31 843."""
    return f"{number:,}".replace(",", "\u2009")


def size_text(problem: _Sized) -> str:
    """Return e.g. `49 cameras, 7 776 points, 31 843 observations`."""
    return (
        f"{count(problem.num_cameras)} cameras, {count(problem.num_points)} points, "
        f"{count(problem.num_observations)} observations"
    )
