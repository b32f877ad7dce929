"""What the examples of docs/theory share: arguments, a table on the terminal, figures on disk.

Figures go to a fresh scratch folder, whose name is printed. The pages' own are made again with
`--output docs/theory/images`.
"""

import argparse
import json
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from raylign.viz import style

DPI = 115

# One colour, line and marker each, so that a print in grey still tells them apart.
LINES: Sequence[dict[str, str]] = (
    {"color": style.BEFORE, "linestyle": "-", "marker": "o"},
    {"color": style.AFTER, "linestyle": "-", "marker": "s"},
    {"color": style.ACCENT, "linestyle": "--", "marker": "^"},
    {"color": style.CAMERA, "linestyle": ":", "marker": "D"},
)

Result = dict[str, Any]


def run(
    description: str,
    measure: Callable[[bool], Result],
    draw: Callable[[Result], dict[str, Figure]],
) -> None:
    """Measure, draw and save: `--quick` is small enough for a test, `--json` keeps the numbers."""
    parser = argparse.ArgumentParser(description=description.split("\n")[0])
    parser.add_argument("--output", type=Path, help="folder of the figures (default: scratch)")
    parser.add_argument("--json", type=Path, help="file for the measured numbers")
    parser.add_argument("--quick", action="store_true", help="smaller, for tests")
    arguments = parser.parse_args()
    result = measure(arguments.quick)
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(result, indent=1), encoding="utf-8")
    output = arguments.output or Path(tempfile.mkdtemp(prefix="raylign-figures-"))
    output.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(style.RC):
        for name, figure in draw(result).items():
            path = output / f"{name}.png"
            figure.savefig(path, dpi=DPI, metadata={"Software": "raylign"})
            print(f"wrote {path}")


def print_table(header: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Print right-aligned columns; floats with four significant digits."""
    text = [list(header)] + [[_cell(value) for value in row] for row in rows]
    widths = [max(len(row[k]) for row in text) for k in range(len(text[0]))]
    for row in text:
        print("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)))
    print()


def _cell(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
