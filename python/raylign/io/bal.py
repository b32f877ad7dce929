"""Bundle Adjustment in the Large text files: `.txt`, `.txt.gz`, `.txt.bz2` and file objects."""

from pathlib import Path
from typing import BinaryIO

from raylign import _core
from raylign._typing import PathLike
from raylign.errors import FormatError
from raylign.io._streams import format_error, path_or_stream, read_all, stream_name
from raylign.io.duplicates import Duplicates
from raylign.scene import BalProblem

# What other files begin with, and what to tell whoever takes them for BAL text.
_FOREIGN = (
    (b"PK\x03\x04", "is an npz (zip) archive; read it with read_npz"),
    (b"ply\n", "is a PLY file, which raylign writes but does not read"),
    (b"ply\r", "is a PLY file, which raylign writes but does not read"),
)


def read_bal(source: PathLike | BinaryIO, *, duplicates: Duplicates = "error") -> BalProblem:
    """Read a bundle adjustment problem in the text format of Agarwal et al.

    The first line says how many cameras, points and observations follow; every observation is
    `camera point u v`; then come nine numbers per camera (angle-axis, translation, f, k1, k2) and
    three per point. Any whitespace separates, CRLF included. gzip and bzip2 are told by content.

    Args:
        source: path, or binary file object, which is read to its end.
        duplicates: what to do when a camera sees a point twice: refuse the file (`error`), keep the
            `first`, the `mean` pixel, or `keep` all (they then count twice in the cost).

    Returns:
        BalProblem: cameras (C, 9), points (P, 3), observations (N, 2) in px, as in the file.

    Raises:
        FormatError: the source is missing, empty, cut short, no BAL problem, or holds a number that
            is not finite; the error has `file`, `line`, `field` and `reason`. Nothing is returned
            in part, and no more memory is taken than a small multiple of the file's size.
        OptionsError: `duplicates` is none of the four.
        TypeError: `source` is neither a path nor a binary file object.

    Note: independent of the locale. Releases the GIL.
    Source: Agarwal et al., Bundle Adjustment in the Large, ECCV 2010.

    Example:
        >>> import io
        >>> text = b"1 1 1  0 0 -5.0 2.5  0 0 0 0 0 -2 10 0 0  1 -0.5 0"
        >>> read_bal(io.BytesIO(text))
        <BalProblem: 1 cameras, 1 points, 1 observations>
    """
    resolved = path_or_stream(source)
    if isinstance(resolved, str):
        try:
            return _core.read_bal(resolved, duplicates=duplicates)
        except FormatError:
            _refuse_foreign(_first_bytes(resolved), resolved)
            raise
    name, text = stream_name(resolved), read_all(resolved)
    _refuse_foreign(text[:4], name)
    return _core.parse_bal(text, name=name, duplicates=duplicates)


def _first_bytes(path: str) -> bytes:
    if not Path(path).is_file():  # a pipe has been read already
        return b""
    try:
        with Path(path).open("rb") as stream:
            return stream.read(4)
    except OSError:
        return b""


def _refuse_foreign(start: bytes, name: str) -> None:
    for magic, reason in _FOREIGN:
        if start.startswith(magic):
            raise format_error(name, "", reason) from None


def write_bal(problem: BalProblem, target: PathLike | BinaryIO) -> None:
    """Write a bundle adjustment problem so that reading it back gives bit-equal numbers.

    Args:
        problem: not modified. Colours have no place in the format; `write_npz` keeps them.
        target: path, compressed when it ends in `.gz` or `.bz2`, or binary file object
            (uncompressed). A path is written to a temporary file beside it, renamed at the end:
            after a failure the old file is as it was.

    Raises:
        FormatError: the target cannot be written, a number is not finite, or the problem has no
            camera, point or observation (which `read_bal` would refuse).
        ShapeError: the arrays of `problem` disagree.
        TypeError: `target` is neither a path nor a binary file object.

    Note: deterministic, also when compressed. Releases the GIL for paths.
    """
    resolved = path_or_stream(target)
    if isinstance(resolved, str):
        _core.write_bal(problem, resolved)
    else:
        resolved.write(_core.format_bal(problem))
