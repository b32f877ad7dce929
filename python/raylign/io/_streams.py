"""Turn what users pass as a source or a target into a path or a binary stream."""

import io
import os
from pathlib import Path
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


def format_error(file: str, field: str, reason: str, *, line: int = 0) -> FormatError:
    """Build the error that the C++ readers throw, for the readers written in Python."""
    place = f"{file}:{line}: " if line else f"{file}: "
    error = FormatError(place + (f"{field}: " if field else "") + reason)
    error.file, error.line, error.field, error.reason = file, line, field, reason
    return error


def write_atomically(target: PathLike | BinaryIO, data: bytes) -> None:
    """Write a whole file; a path is replaced only once its new content is complete.

    Raises:
        FormatError: the target cannot be written.
        TypeError: `target` is neither a path nor a binary file object.
    """
    resolved = path_or_stream(target)
    if not isinstance(resolved, str):
        resolved.write(data)
        return
    path = Path(resolved)
    temporary = path.with_name(f"{path.name}.tmp-{os.getpid()}")
    try:
        with temporary.open("xb") as stream:
            stream.write(data)
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        reason = f"cannot be written: {error.strerror or error}"
        raise format_error(resolved, "", reason) from error
