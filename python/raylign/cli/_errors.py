"""How errors reach the user: one line on stderr and an exit status, no traceback."""

from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from raylign.cli._console import complain
from raylign.errors import Error, OptionsError

EXIT_FAILURE = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130  # 128 + SIGINT, as shells report it


class PlainCommand(TyperCommand):
    """A command whose help shows no type for flags and whose usage errors are plain sentences."""

    def get_params(self, ctx: Any) -> Any:
        """Return the options and arguments, `--help` among them."""
        return _without_flag_types(super().get_params(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line; pydantic's `Value error, ` says nothing to the user."""
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter as error:
            error.message = error.message.removeprefix("Value error, ")
            raise


class PlainGroup(TyperGroup):
    """The same for a command that only holds others."""

    def get_params(self, ctx: Any) -> Any:
        """Return the options, `--help` among them."""
        return _without_flag_types(super().get_params(ctx))


class ReportingGroup(PlainGroup):
    """Runs a command and turns what it raises into a message and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command; `--debug` lets the exception through."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:  # `raylign info | head`: typer ends quietly
            raise
        except KeyboardInterrupt as interrupt:
            complain(str(interrupt) or "interrupted")
            raise typer.Exit(EXIT_INTERRUPTED) from None
        except (Error, OSError) as error:
            if ctx.params.get("debug"):
                raise
            complain(describe(error))
            status = EXIT_USAGE if isinstance(error, OptionsError) else EXIT_FAILURE
            raise typer.Exit(status) from error


def describe(error: Exception) -> str:
    """One line that says what went wrong, with the file it happened to."""
    if isinstance(error, OSError) and error.strerror and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error) or type(error).__name__


def _without_flag_types(parameters: Any) -> Any:
    for parameter in parameters:
        if getattr(parameter, "is_flag", False) and parameter.metavar is None:
            parameter.metavar = ""
    return parameters
