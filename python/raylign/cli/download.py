"""`raylign download`: fetch a public data set and check it."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from raylign.cli._console import complain, make_console, say
from raylign.cli._errors import EXIT_FAILURE, describe
from raylign.cli._progress import byte_progress
from raylign.datasets import DownloadError, bal_entries, fetch, find_bal
from raylign.errors import OptionsError


def download(
    names: Annotated[
        list[str] | None, typer.Argument(help="E.g. ladybug-49 or problem-49-7776-pre.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Existing folder for the files.")
    ] = (Path()),
    mirror: Annotated[
        str | None, typer.Option(help="Base URL in place of the scheme and host of the original.")
    ] = None,
    list_only: Annotated[bool, typer.Option("--list", help="List what there is and exit.")] = False,
) -> None:
    """Download BAL problems as text; a file that is not what the registry says is refused.

    ladybug-49 becomes problem-49-7776-pre.txt. One that fails does not keep the next from coming.
    """
    console = make_console()
    if list_only:
        _print_list(console)
        return
    if not names:
        raise OptionsError("nothing to download: give a name, or --list to see them all")
    failed = False
    for entry in [find_bal(name) for name in names]:  # a wrong name stops before the first byte
        try:
            with byte_progress(console, entry.alias) as progress:
                path = fetch(entry.name, directory=output, mirror=mirror, progress=progress)
        except DownloadError as error:
            failed = True
            complain(describe(error))
        else:
            say(console, f"{entry.name}: checked, in {path}")
    if failed:
        raise typer.Exit(EXIT_FAILURE)


def _print_list(console: Console) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    entries = bal_entries()
    longest = max(len(f"bal/{entry.alias}") for entry in entries)
    table.add_column("name", no_wrap=True, min_width=longest)
    table.add_column("file", overflow="fold")
    for heading in ("cameras", "points", "observations"):
        table.add_column(heading, justify="right")
    table.add_column("checked by")
    for entry in entries:
        table.add_row(
            f"bal/{entry.alias}",
            entry.name,
            str(entry.cameras),
            str(entry.points),
            str(entry.observations or ""),
            "sha256" if entry.sha256 else "counts, parsing",
        )
    console.print(table)
