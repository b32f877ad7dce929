"""The consoles that commands print on."""

from rich.console import Console


def make_console(*, quiet: bool = False) -> Console:
    """Return a console for standard output; brackets in file names and units are not markup."""
    return Console(quiet=quiet, markup=False, highlight=False)


def say(console: Console, text: str, style: str | None = None) -> None:
    """Print one line as it is, however narrow the terminal: paths can be copied."""
    console.print(text, style=style, soft_wrap=True)
