"""`raylign synthetic`: scenes with a known truth."""

import enum
import inspect
from pathlib import Path
from typing import Annotated, Any

import typer

from raylign import synthetic
from raylign.cli import _synthetic_sequence
from raylign.cli._console import make_console, say
from raylign.cli._errors import PlainCommand, PlainGroup
from raylign.cli._files import BAL_SUFFIXES, check_distinct, check_problem_target, write_problem
from raylign.cli._options import choice_option
from raylign.cli._progress import count_progress

app = typer.Typer(cls=PlainGroup, help="Make scenes with a known truth.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    """Make scenes with a known truth."""


def bal(*, output: Path, truth: Path | None, quiet: bool, **fields: Any) -> None:
    """Write a synthetic BAL problem, streaming: millions of observations in bounded memory.

    The file holds the perturbed start, `--truth` the same scene with the exact cameras and points.
    `.npz` keeps the colours too, but is made in memory.
    """
    check_distinct(None, [output, truth])
    paths = [path for path in (output, truth) if path is not None]
    for path in paths:
        check_problem_target(path, (*BAL_SUFFIXES, ".npz"))
    defaults = synthetic.BalOptions()
    options = synthetic.BalOptions(
        **{name: _library_value(value, getattr(defaults, name)) for name, value in fields.items()}
    )
    console = make_console(quiet=quiet)
    if all(path.name.lower().endswith(BAL_SUFFIXES) for path in paths):
        with count_progress(console, "writing") as progress:
            synthetic.write_bal(output, options=options, truth_path=truth, progress=progress)
    else:
        scene = synthetic.bal(options)
        for path, problem in zip(paths, (scene.problem, scene.truth), strict=False):
            write_problem(problem, path)
    for path in paths:
        say(console, f"wrote {path}")


def _library_value(value: Any, default: Any) -> Any:
    return type(default)[value.name] if isinstance(default, enum.Enum) else value


def _signature() -> inspect.Signature:
    """One command-line option per field of BalOptions: same name, default and description."""
    parameters = [
        _keyword("output", Annotated[Path, typer.Option("--output", "-o", help="File to write.")]),
        _keyword(
            "truth",
            Annotated[Path | None, typer.Option("--truth", help="File for the exact scene.")],
            None,
        ),
    ]
    defaults = synthetic.BalOptions()
    for name in synthetic.BalOptions.__fields__:
        default: Any = getattr(defaults, name)
        annotation: Any = type(default)
        if isinstance(default, enum.Enum):
            annotation = _lower_case(annotation)
            default = annotation[default.name]
        flag, text = "--" + name.replace("_", "-"), getattr(synthetic.BalOptions, name).__doc__
        if isinstance(default, enum.Enum):
            option = choice_option(annotation, flag, help=text.rstrip("."))
        else:
            option = typer.Option(flag, help=text)
        parameters.append(_keyword(name, Annotated[annotation, option], default))
    quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
    parameters.append(_keyword("quiet", quiet, False))
    return inspect.Signature(parameters)


def _lower_case(enum_type: type[enum.Enum]) -> Any:
    names = {member.name: member.name.lower() for member in enum_type}
    return enum.Enum(enum_type.__name__, names, type=str)


def _keyword(
    name: str, annotation: Any, default: Any = inspect.Parameter.empty
) -> inspect.Parameter:
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, kind, default=default, annotation=annotation)


bal.__signature__ = _signature()  # type: ignore[attr-defined]
app.command("bal", cls=PlainCommand)(bal)
app.command("sequence", cls=PlainCommand)(_synthetic_sequence.sequence)
