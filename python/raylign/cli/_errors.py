"""How errors reach the user: one line on stderr and an exit status, no traceback."""

from typing import Any

import typer
from rich.console import Console
from typer.core import TyperGroup

from raylign.errors import Error, OptionsError

EXIT_FAILURE = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130  # 128 + SIGINT, as shells report it


class ReportingGroup(TyperGroup):
    """Runs a command and turns what it raises into a message and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command; `--debug` lets the exception through."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:  # `raylign info | head`: typer ends quietly
            raise
        except KeyboardInterrupt:
            raise _stop("interrupted", EXIT_INTERRUPTED) from None
        except (Error, OSError) as error:
            if ctx.params.get("debug"):
                raise
            status = EXIT_USAGE if isinstance(error, OptionsError) else EXIT_FAILURE
            raise _stop(_describe(error), status) from error


def _describe(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error) or type(error).__name__


def _stop(message: str, status: int) -> typer.Exit:
    console = Console(stderr=True, soft_wrap=True)
    console.print(f"error: {message}", style="bold red", markup=False, highlight=False)
    return typer.Exit(status)
