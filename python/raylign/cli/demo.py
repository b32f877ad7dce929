"""`raylign demo`: a bundle adjustment with a known truth, from shipped data to pictures."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from raylign._resources import data_file
from raylign.bundle import BundleConfig, BundleOptions, BundleResult, LmOptions, Termination
from raylign.cli._errors import EXIT_INTERRUPTED
from raylign.cli._files import check_report_target
from raylign.cli.bundle import describe, solve
from raylign.errors import Error
from raylign.evaluate import camera_center_errors
from raylign.io import read_bal
from raylign.scene import BalProblem

_PROBLEM = "bal/street.txt.gz"
_TRUTH = "bal/street-truth.txt.gz"


def demo(
    output: Annotated[
        Path, typer.Option("--output", "-o", "--report", help="Folder for the report.")
    ] = Path("raylign-demo"),
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Solve a synthetic street scene that comes with raylign and draw what happened."""
    check_report_target(output)
    before, truth = read_bal(data_file(_PROBLEM)), read_bal(data_file(_TRUTH))
    config, options = BundleConfig(), BundleOptions(lm=LmOptions(max_num_iterations=30))
    console = Console(quiet=quiet)
    console.print(f"synthetic street: {describe(before)}, truth known", highlight=False)
    result = solve(before, config, options, console=console)
    if not result.summary.is_usable():
        raise Error(f"the solve failed: {result.summary.message}")
    errors = [_center_rmse(problem, truth) for problem in (before, result.problem)]
    from raylign.viz import bundle_report  # matplotlib: late, so that the table comes at once

    with console.status("drawing"):
        bundle_report(
            before,
            result.problem,
            result.summary,
            output,
            options=options,
            config=config,
            title="raylign demo: a synthetic street",
            extra={"truth": {"camera_center_rmse": {"before": errors[0], "after": errors[1]}}},
        )
    console.print(_table(before, truth, result, errors))
    console.print(f"pictures: {output / 'index.html'}", highlight=False, soft_wrap=True)
    if result.summary.termination is Termination.USER_STOPPED:
        raise typer.Exit(EXIT_INTERRUPTED)


def _center_rmse(problem: BalProblem, truth: BalProblem) -> float:
    return float(np.sqrt(np.mean(camera_center_errors(problem, truth) ** 2)))


def _table(
    before: BalProblem, truth: BalProblem, result: BundleResult, errors: list[float]
) -> Table:
    table = Table("", box=None, header_style="bold")
    for heading in ("before", "after", "truth"):
        table.add_column(heading, justify="right")
    problems = (before, result.problem, truth)
    _add_row(table, "cost ½ Σ ‖r‖² [px²]", [problem.cost() for problem in problems])
    _add_row(table, "RMSE [px per coordinate]", [p.statistics().rmse for p in problems])
    _add_row(table, "camera centres off by [m]", [*errors, 0.0])
    return table


def _add_row(table: Table, name: str, values: list[Any]) -> None:
    table.add_row(name, *(f"{value:.5g}" for value in values))
