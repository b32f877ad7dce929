"""The command line `raylign`: one file per command, each a thin layer over the Python API."""

import signal
from typing import Annotated

import typer

from raylign import __version__
from raylign.cli import (
    bundle,
    convert,
    demo,
    download,
    evaluate,
    info,
    photometric,
    synthetic,
    track,
)
from raylign.cli._errors import PlainCommand, ReportingGroup

__all__ = ["app", "main"]

app = typer.Typer(
    name="raylign",
    cls=ReportingGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("bundle", cls=PlainCommand)(bundle.bundle)
app.command("convert", cls=PlainCommand)(convert.convert)
app.command("demo", cls=PlainCommand)(demo.demo)
app.command("download", cls=PlainCommand)(download.download)
app.command("evaluate", cls=PlainCommand)(evaluate.evaluate)
app.command("info", cls=PlainCommand)(info.info)
app.command("photometric", cls=PlainCommand)(photometric.photometric)
app.command("track", cls=PlainCommand)(track.track)
app.add_typer(synthetic.app, name="synthetic")


def _print_version(value: bool) -> None:
    if value:
        typer.echo(f"raylign {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Show and exit."),
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Bundle adjustment from pixels or from grey values, direct tracking, evaluation."""


def main() -> None:
    """Entry point of the `raylign` script; SIGTERM is treated like Ctrl-C."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    app()
