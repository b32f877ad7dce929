"""`raylign demo`: bundle adjustments with a known truth, from data to pictures."""

import enum
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from raylign._resources import data_file
from raylign.bundle import BundleConfig, BundleOptions, Termination
from raylign.cli._console import make_console, say
from raylign.cli._errors import EXIT_INTERRUPTED
from raylign.cli._files import check_report_target
from raylign.cli._options import choice_option
from raylign.cli._photometric_demo import refine_room
from raylign.cli.bundle import describe, solve
from raylign.errors import Error
from raylign.evaluate import camera_center_errors
from raylign.io import read_bal
from raylign.robust import Loss
from raylign.scene import BalProblem


class Scene(enum.StrEnum):
    """The shipped scenes, `data/bal/<name>.txt.gz`, and a room that is rendered."""

    ORBIT = "orbit"
    STREET = "street"
    ROOM = "room"


# The street has 2 % outliers, which a convex loss does not get rid of; the orbit has none.
_LOSS = {Scene.ORBIT: "trivial", Scene.STREET: "cauchy:1"}


def demo(
    output: Annotated[
        Path, typer.Option("--output", "-o", "--report", help="Folder for the report.")
    ] = Path("raylign-demo"),
    scene: Annotated[Scene, choice_option(Scene, "--scene", help="What to solve")] = Scene.ORBIT,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Solve a synthetic scene that comes with raylign and draw what happened.

    orbit and street are bundle adjustments from pixels, room one from grey values.
    """
    check_report_target(output)
    if scene is Scene.ROOM:
        _refine_room(output, make_console(quiet=quiet))
        return
    before = read_bal(data_file(f"bal/{scene}.txt.gz"))
    truth = read_bal(data_file(f"bal/{scene}-truth.txt.gz"))
    config, options = BundleConfig(), BundleOptions(loss=Loss.parse(_LOSS[scene]))
    console = make_console(quiet=quiet)
    say(console, f"synthetic {scene}: {describe(before)}; loss {_LOSS[scene]}")
    result = solve(before, config, options, console=console)
    if not result.summary.is_usable():
        raise Error(f"the solve failed: {result.summary.message}")
    say(console, result.summary.brief_report())
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
            title=f"raylign demo: a synthetic {scene}",
            extra={"truth": {"camera_center_rmse": {"before": errors[0], "after": errors[1]}}},
        )
    console.print()
    console.print(_table([before, result.problem, truth], [*errors, 0.0], options.loss))
    say(console, f"\npictures: {output / 'index.html'}")
    if result.summary.termination is Termination.USER_STOPPED:
        raise typer.Exit(EXIT_INTERRUPTED)


def _refine_room(output: Path, console: Console) -> None:
    result = refine_room(output, console)
    say(console, f"\npictures: {output / 'index.html'}")
    if result.summary.termination is Termination.USER_STOPPED:
        raise typer.Exit(EXIT_INTERRUPTED)


def _center_rmse(problem: BalProblem, truth: BalProblem) -> float:
    return float(np.sqrt(np.mean(camera_center_errors(problem, truth) ** 2)))


def _robust_cost(problem: BalProblem, loss: Loss) -> float:
    rho, _, _ = loss.evaluate(np.sum(problem.residuals() ** 2, axis=1))
    return 0.5 * float(np.sum(rho))


def _table(problems: list[BalProblem], center_errors: list[float], loss: Loss) -> Table:
    statistics = [problem.statistics() for problem in problems]
    table = Table("", box=None, header_style="bold", pad_edge=False)
    for heading in ("before", "after", "truth"):
        table.add_column(heading, justify="right")
    rows = {
        "cost ½ Σ ρ(‖r‖²) [px²]": [_robust_cost(problem, loss) for problem in problems],
        "median ‖r‖ [px]": [entry.median_error for entry in statistics],
        "camera centres off by [m], RMS": center_errors,
    }
    for name, values in rows.items():
        table.add_row(name, *(f"{value:.4g}" for value in values))
    return table
