"""The consoles that commands print on."""

from rich.console import Console

_PIPE_WIDTH = 200  # columns of a table that goes into a file or a pipe


def make_console(*, quiet: bool = False) -> Console:
    """Return a console for standard output; brackets in file names and units are not markup."""
    console = Console(quiet=quiet, markup=False, highlight=False)
    if not console.is_terminal:
        console.width = _PIPE_WIDTH
    return console


def say(console: Console, text: str, style: str | None = None) -> None:
    """Print one line as it is, however narrow the terminal: paths can be copied."""
    console.print(text, style=style, soft_wrap=True)


def warn(text: str) -> None:
    """Print one yellow line on standard error."""
    _say_on_stderr(f"warning: {text}", "yellow")


def complain(text: str) -> None:
    """Print one red line on standard error."""
    _say_on_stderr(f"error: {text}", "bold red")


def _say_on_stderr(text: str, style: str) -> None:
    say(Console(stderr=True, markup=False, highlight=False), text, style)
