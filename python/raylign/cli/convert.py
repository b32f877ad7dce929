"""`raylign convert`: from one file format to another."""

from pathlib import Path
from typing import Annotated

import typer

from raylign.cli._choices import Duplicates
from raylign.cli._console import make_console, say
from raylign.cli._files import check_distinct, check_problem_target, read_problem, write_problem
from raylign.cli._options import DuplicatesOpt


def convert(
    source: Annotated[Path, typer.Argument(help="BAL text (.txt, .gz, .bz2) or .npz.")],
    target: Annotated[Path, typer.Argument(help="The same, or .ply (points and cameras).")],
    duplicates: DuplicatesOpt = Duplicates.ERROR,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Convert a problem; the suffixes name the formats, numbers keep every bit."""
    check_distinct(source, [target])
    check_problem_target(target)
    problem = read_problem(source, duplicates)
    note = write_problem(problem, target)
    text = (
        f"wrote {target}: {problem.num_cameras} cameras, {problem.num_points} points, "
        f"{problem.num_observations} observations{note}"
    )
    say(make_console(quiet=quiet), text)
