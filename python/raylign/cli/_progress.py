"""What a running solve shows: a table row per iteration over a progress bar, or g2o's log lines."""

import contextlib
from collections.abc import Iterator
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    DownloadColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)

from raylign.cli._choices import LogStyle
from raylign.cli._console import say

# 79 characters with the mark of a rejected step: one line of the narrowest usual terminal.
_COLUMNS = (  # heading, width, format, field
    ("iter", 5, "d", "iteration"),
    ("cost", 14, ".7e", "cost"),
    ("change", 10, ".2e", "cost_change"),
    ("|grad|", 9, ".2e", "gradient_max_norm"),
    ("|step|", 9, ".2e", "step_norm"),
    ("lambda", 9, ".2e", "lambda_"),
    ("lin", 5, "d", "linear_solver_iterations"),
    ("s", 8, ".3f", "iteration_time_s"),
    ("total s", 8, ".3f", "cumulative_time_s"),
)


def table_header() -> str:
    """Heading of the iteration table."""
    return "".join(f"{name:>{width}}" for name, width, _, _ in _COLUMNS)


def table_row(row: Any) -> str:
    """One iteration, aligned with `table_header()`; ends in `x` when rejected, `!` when invalid."""
    text = "".join(f"{getattr(row, field):>{width}{form}}" for _, width, form, field in _COLUMNS)
    return text + _mark(row)


def _mark(row: Any) -> str:
    if row.step_is_accepted or row.iteration == 0:
        return ""
    return " x" if row.step_is_valid else " !"


def g2o_line(
    row: Any, *, iteration: int | None = None, time_s: float | None = None, num_trials: int = 1
) -> str:
    """One iteration as g2o's block solver logs it; chi2 = 2 · cost."""
    return (
        f"iteration= {row.iteration if iteration is None else iteration}  "
        f"chi2= {2.0 * row.cost:.6f}  "
        f"time= {row.iteration_time_s if time_s is None else time_s:.6g}  "
        f"cumTime= {row.cumulative_time_s:.6g}  "
        f"edges= {row.num_residual_blocks}  schur= 1  "
        f"lambda= {row.lambda_:.6f}  levenbergIter= {num_trials}"
    )


class SolveDisplay:
    """Callback of `raylign.bundle.adjust` that prints each iteration."""

    def __init__(self, console: Console, log: LogStyle, max_num_iterations: int) -> None:
        self._console = console
        self._log = log
        self._max = max_num_iterations
        self._progress: Progress | None = None
        self._task = TaskID(0)

    @contextlib.contextmanager
    def running(self) -> Iterator["SolveDisplay"]:
        """Show the bar while the solve runs; pipes and files get plain lines."""
        if self._log is LogStyle.TABLE:
            say(self._console, table_header(), style="bold")
        if not self._console.is_terminal:
            yield self
            return
        columns = (
            TextColumn("[bold]solving"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("iterations"),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=self._console, transient=True) as progress:
            self._progress = progress
            self._task = progress.add_task("solve", total=self._max)
            yield self
        self._progress = None

    def __call__(self, row: Any) -> None:
        """Print one iteration; None lets the solve go on."""
        if self._log is LogStyle.G2O:
            say(self._console, g2o_line(row))
        else:
            say(self._console, table_row(row), style="red" if _mark(row) else None)
        if self._progress is not None:
            self._progress.update(self._task, completed=row.iteration)


class PhotometricDisplay:
    """Callback of `raylign.photometric.adjust` that prints each iteration.

    G2O counts as g2o does: an iteration ends with a step that is accepted, its refused trials are
    its levenbergIter, and the first line, iteration 0, comes after the first step.
    """

    def __init__(self, console: Console, log: LogStyle) -> None:
        self._console = console
        self._log = log
        self._num_lines = 0
        self._num_trials = 0
        self._trials_time_s = 0.0

    @contextlib.contextmanager
    def running(self) -> Iterator["PhotometricDisplay"]:
        """Show that something goes on; pipes and files get plain lines."""
        if self._log is LogStyle.TABLE:
            say(self._console, table_header(), style="bold")
        columns = (TextColumn("[bold]solving"), BarColumn(), TimeElapsedColumn())
        disable = not self._console.is_terminal
        with Progress(*columns, console=self._console, transient=True, disable=disable) as bar:
            bar.add_task("solve", total=None)
            yield self

    def __call__(self, row: Any) -> None:
        """Print one iteration; None lets the solve go on."""
        if self._log is LogStyle.TABLE:
            say(self._console, table_row(row), style="red" if _mark(row) else None)
            return
        if row.iteration == 0:
            say(self._console, f"start chi2= {2.0 * row.cost:.6f}")
            return
        self._num_trials += 1
        self._trials_time_s += row.iteration_time_s
        if not row.step_is_accepted:
            return
        line = g2o_line(
            row,
            iteration=self._num_lines,
            time_s=self._trials_time_s,
            num_trials=self._num_trials,
        )
        say(self._console, line)
        self._num_lines += 1
        self._num_trials, self._trials_time_s = 0, 0.0


@contextlib.contextmanager
def byte_progress(console: Console, label: str) -> Iterator[Any]:
    """Yield a function (bytes done, bytes in all or 0) that moves a bar."""
    columns = (TextColumn(label), BarColumn(), DownloadColumn(), TimeElapsedColumn())
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total or None)


@contextlib.contextmanager
def count_progress(console: Console, label: str) -> Iterator[Any]:
    """Yield a function (items done, items in all) that moves a bar."""
    columns = (TextColumn(label), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
