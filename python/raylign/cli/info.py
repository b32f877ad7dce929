"""`raylign info`: what is installed and what it runs on."""

import json
from typing import Annotated, Any

import typer
from rich.table import Table

from raylign._build_info import build_info
from raylign.cli._console import make_console


def info(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show versions, build flags, BLAS, CPU features and threads: what a bug report needs."""
    facts = build_info()
    if as_json:
        typer.echo(json.dumps(facts, indent=2))
        return
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(style="bold")
    table.add_column(overflow="fold")
    for name, value in _rows(facts):
        table.add_row(name, value)
    make_console().print(table)


def _rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    rows = []
    for name, value in facts.items():
        if isinstance(value, dict):
            rows += [(f"{name} {key}", str(item) or "none") for key, item in value.items()]
        elif isinstance(value, list):
            rows.append((name, " ".join(value) or "none"))
        else:
            rows.append((name, "none" if value is None else str(value)))
    return [(name.replace("_", " "), value) for name, value in rows]
