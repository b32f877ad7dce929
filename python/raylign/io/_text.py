"""Lines and numbers of text files, with the place of whatever is wrong."""

import math
from collections.abc import Iterator
from typing import BinaryIO

from raylign._typing import PathLike
from raylign.io._streams import format_error, path_or_stream, read_all, stream_name

_MAX_SHOWN = 40  # characters of a bad token in a message


def read_text(source: PathLike | BinaryIO) -> tuple[str, str]:
    """Name and text of a file.

    Raises:
        FormatError: it cannot be read, or is no UTF-8 text.
        TypeError: `source` is neither a path nor a binary file object.
    """
    resolved = path_or_stream(source)
    if isinstance(resolved, str):
        name = resolved
        try:
            with open(resolved, "rb") as stream:  # noqa: PTH123  # a str already
                data = stream.read()
        except OSError as error:
            raise format_error(name, "", f"cannot be opened: {error.strerror}") from error
    else:
        name, data = stream_name(resolved), read_all(resolved)
    try:
        return name, data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise format_error(name, "", "is no UTF-8 text", line=line) from error


def data_lines(text: str) -> Iterator[tuple[int, str]]:
    """(1-based number, content) of the lines that hold data: not empty, no `#` comment."""
    for number, line in enumerate(text.splitlines(), start=1):
        content = line.strip()
        if content and not content.startswith("#"):
            yield number, content


def number(token: str, *, file: str, line: int, field: str) -> float:
    """One finite number.

    Raises:
        FormatError: it is none.
    """
    try:
        value = float(token)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        reason = f"expected a finite number, got {shown(token)}"
        raise format_error(file, field, reason, line=line)
    return value


def numbers(
    content: str, fields: tuple[str, ...], *, file: str, line: int, separator: str | None = None
) -> list[float]:
    """The numbers of one line, as many as there are `fields`.

    Raises:
        FormatError: one is missing, too many, or not a finite number.
    """
    tokens = content.split(separator)
    if len(tokens) != len(fields):
        expected = f"expected {len(fields)} numbers ({' '.join(fields)}), got {len(tokens)}"
        raise format_error(file, "", expected, line=line)
    return [
        number(token, file=file, line=line, field=field)
        for token, field in zip(tokens, fields, strict=True)
    ]


def shown(token: str) -> str:
    """A token as a message can hold it."""
    return repr(token if len(token) <= _MAX_SHOWN else token[:_MAX_SHOWN] + "…")
