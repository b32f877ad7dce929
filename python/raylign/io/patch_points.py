"""Points with grey values around them, `points.txt`: the input of photometric bundle adjustment."""

import itertools
from collections import Counter
from typing import BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

from raylign._typing import F32, F64, PathLike
from raylign.errors import OptionsError, ShapeError
from raylign.io._streams import format_error, write_atomically
from raylign.io._text import data_lines, number, read_text

_COORDINATES = ("x", "y", "z")


class PatchPoints(NamedTuple):
    """What `points.txt` holds.

    Attributes:
        points: (N, 3) float64, world frame, scene units.
        patches: (N, n) float32 grey values in the order of the file; n = 0: none.
    """

    points: F64
    patches: F32


def read_patch_points(source: PathLike | BinaryIO, *, num_values: int | None = None) -> PatchPoints:
    r"""Read one point per line, `x y z g0 g1 …`, with as many grey values in each.

    Empty lines and `#` comments are skipped; nothing else ends the file or is left out, a point at
    x = 0 neither.

    Args:
        source: path, or binary file object, which is read to its end.
        num_values: grey values that each line must have, >= 0. Default: as most lines have.

    Returns:
        PatchPoints: nothing is known about the order of the pixels; files of the original exercise
        go by columns, u outermost.

    Raises:
        FormatError: the file cannot be read or holds no point; a line has another count of numbers
            than the others, or one that is not finite. The error has `file`, `line`, `field` and
            `reason`.
        OptionsError: `num_values` is negative.
        TypeError: `source` is neither a path nor a binary file object.

    Example:
        >>> import io
        >>> points, patches = read_patch_points(io.BytesIO(b"0 1 2 10.5 20\n-1 0 3 7 8\n"))
        >>> points.tolist(), patches.tolist()
        ([[0.0, 1.0, 2.0], [-1.0, 0.0, 3.0]], [[10.5, 20.0], [7.0, 8.0]])
    """
    if num_values is not None and num_values < 0:
        raise OptionsError(f"num_values must be >= 0, got {num_values}")
    name, text = read_text(source)
    rows = [(line, content.split()) for line, content in data_lines(text)]
    if not rows:
        raise format_error(name, "", "holds no point")
    width = _expected_width(rows) if num_values is None else 3 + num_values
    for line, tokens in rows:
        if len(tokens) != width:
            reason = f"{width} numbers expected but {len(tokens)} found in line {line}"
            raise format_error(name, "", reason, line=line)
    table = _table(rows, name)
    with np.errstate(over="ignore"):  # checked: a grey value too large for float32
        patches = table[:, 3:].astype(np.float32)
    if not np.isfinite(patches).all():
        row, column = np.argwhere(~np.isfinite(patches))[0]
        reason = f"must fit into float32, got {table[row, 3 + column]:g}"
        raise format_error(name, f"g{column}", reason, line=rows[row][0])
    return PatchPoints(np.ascontiguousarray(table[:, :3]), patches)


def write_patch_points(
    points: npt.ArrayLike, target: PathLike | BinaryIO, *, patches: npt.ArrayLike | None = None
) -> None:
    r"""Write points and their grey values with as many digits as it takes to read them back.

    Args:
        points: (N, 3) real.
        target: path, replaced only once the file is complete, or binary file object.
        patches: (N, n) real, written as float32. Default: none, three numbers a line.

    Raises:
        ShapeError: shapes disagree, or a number is not finite.
        FormatError: the target cannot be written.
        TypeError: `target` is neither a path nor a binary file object.

    Example:
        >>> import io
        >>> stream = io.BytesIO()
        >>> write_patch_points([[0, 0.5, 2]], stream, patches=[[140.453, 7]])
        >>> stream.getvalue()
        b'0.0 0.5 2.0 140.453 7.0\n'
    """
    xyz = np.asarray(points, np.float64)
    grey = np.zeros((len(xyz), 0)) if patches is None else np.asarray(patches)
    if xyz.shape != (len(xyz), 3) or grey.ndim != 2 or len(grey) != len(xyz):
        raise ShapeError(f"points must be (N, 3) and patches (N, n), got {xyz.shape}, {grey.shape}")
    if not (np.isfinite(xyz).all() and np.isfinite(grey).all()):
        raise ShapeError("points and patches must be finite")
    shortest = grey.astype(np.float32).astype(str).tolist()
    lines = (
        " ".join(itertools.chain(map(repr, row), values))
        for row, values in zip(xyz.tolist(), shortest, strict=True)
    )
    write_atomically(target, "".join(line + "\n" for line in lines).encode())


def _expected_width(rows: list[tuple[int, list[str]]]) -> int:
    """What most lines have, at least x y z: so that the error names the line that differs."""
    return max(3, Counter(len(tokens) for _, tokens in rows).most_common(1)[0][0])


def _table(rows: list[tuple[int, list[str]]], name: str) -> F64:
    try:
        table = np.array([tokens for _, tokens in rows], dtype=np.float64)
    except ValueError:
        table = np.full((1, 1), np.nan)
    if not np.isfinite(table).all():  # line by line, to find the place
        fields = itertools.chain(_COORDINATES, (f"g{i}" for i in itertools.count()))
        names = list(itertools.islice(fields, len(rows[0][1])))
        for line, tokens in rows:
            for field, token in zip(names, tokens, strict=True):
                number(token, file=name, line=line, field=field)
    return table
