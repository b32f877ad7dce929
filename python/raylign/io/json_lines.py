"""A log with one JSON object per line, written as it happens."""

import json
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self

from raylign._json import jsonable
from raylign._typing import PathLike
from raylign.io._streams import format_error, path_or_stream
from raylign.io._text import read_text


class JsonLinesWriter:
    """Writes rows to a `.jsonl` file; each is on the disk when `write` returns.

    Floats keep every bit; those that JSON cannot hold (nan, inf) become strings that `float()`
    reads. Arrays become lists, enumerators their lower-case names.

    Args:
        path: file to create or empty.

    Raises:
        FormatError: the file cannot be written.

    Example:
        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder) / "log.jsonl"
        ...     with JsonLinesWriter(path) as log:
        ...         log.write({"frame": 0, "cost": 0.1})
        ...     read_json_lines(path)
        [{'frame': 0, 'cost': 0.1}]
    """

    def __init__(self, path: PathLike) -> None:
        resolved = path_or_stream(path)
        if not isinstance(resolved, str):
            raise TypeError("JsonLinesWriter needs a path")
        self._name = resolved
        try:
            self._stream = Path(resolved).open("w", encoding="utf-8")  # noqa: SIM115  # see close
        except OSError as error:
            raise format_error(resolved, "", f"cannot be written: {error.strerror}") from error

    def write(self, row: Mapping[str, Any]) -> None:
        """Append one row.

        Raises:
            FormatError: the disk refuses.
            TypeError: a value has no JSON form.
            ValueError: the writer is closed.
        """
        text = json.dumps(jsonable(dict(row)), allow_nan=False)
        try:
            self._stream.write(text + "\n")
            self._stream.flush()
        except OSError as error:
            raise format_error(self._name, "", f"cannot be written: {error.strerror}") from error

    def close(self) -> None:
        """Close the file; a second time does nothing."""
        self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


def read_json_lines(source: PathLike | BinaryIO) -> list[dict[str, Any]]:
    """Read every row of a JSON lines file.

    Args:
        source: path, or binary file object.

    Raises:
        FormatError: the file cannot be read, or a line is no JSON object (the last one of a run
            that was killed, perhaps); the error has `file` and `line`.
    """
    name, text = read_text(source)
    rows = []
    for line, content in enumerate(text.split("\n"), start=1):
        if not content.strip():
            continue
        try:
            row = json.loads(content)
        except (ValueError, RecursionError) as error:
            raise format_error(name, "", f"is no JSON: {error}", line=line) from error
        if not isinstance(row, dict):
            raise format_error(name, "", "expected a JSON object", line=line)
        rows.append(row)
    return rows
