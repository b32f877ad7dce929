"""The command line `raylign`: one file per command, each a thin layer over the Python API."""

from typing import Annotated

import typer

from raylign import __version__
from raylign.cli import bundle, convert, demo, download, info, synthetic
from raylign.cli._errors import ReportingGroup

__all__ = ["app", "main"]

app = typer.Typer(
    name="raylign",
    cls=ReportingGroup,
    help="Bundle adjustment and direct tracking.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("bundle")(bundle.bundle)
app.command("convert")(convert.convert)
app.command("demo")(demo.demo)
app.command("download")(download.download)
app.command("info")(info.info)
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
    """Bundle adjustment and direct tracking."""


def main() -> None:
    """Entry point of the `raylign` script."""
    app()
