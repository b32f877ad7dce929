"""Turn what users pass as a source or a target into a path or a binary stream."""

import io
import os
from typing import BinaryIO

from raylign._typing import PathLike
from raylign.errors import FormatError


def path_or_stream(target: PathLike | BinaryIO) -> str | BinaryIO:
    """Return a path as `str`, and a binary file object as it is.

    Raises:
        TypeError: `target` is neither a text path nor a binary file object.
        ValueError: the path contains a NUL character.
    """
    if isinstance(target, str | os.PathLike):
        path = os.fspath(target)
        if "\0" in path:
            raise ValueError("embedded null character in path")
        return path
    if isinstance(target, io.TextIOBase):
        raise TypeError("file object is in text mode; open it with 'rb' or 'wb'")
    if not (hasattr(target, "read") or hasattr(target, "write")):
        raise TypeError(f"expected a path or a binary file object, got {type(target).__name__}")
    return target


def stream_name(stream: BinaryIO) -> str:
    """Name of the stream for messages: its file name where it has one."""
    name = getattr(stream, "name", None)
    return name if isinstance(name, str) else "<stream>"


def read_all(stream: BinaryIO) -> bytes:
    """Read the rest of a binary stream.

    Raises:
        TypeError: the stream gives text.
    """
    data = stream.read()
    if not isinstance(data, bytes):
        raise TypeError(f"file object must give bytes, gave {type(data).__name__}")
    return data


def format_error(file: str, field: str, reason: str) -> FormatError:
    """Build the error that the C++ readers throw, for the readers written in Python."""
    prefix = f"{file}: {field}: " if field else f"{file}: "
    error = FormatError(prefix + reason)
    error.file, error.line, error.field, error.reason = file, 0, field, reason
    return error
