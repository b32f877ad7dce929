"""Lossless NumPy archives of a problem, colours included."""

import os
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np

from raylign._typing import AnyArray, PathLike
from raylign.errors import FormatError, ShapeError
from raylign.io._streams import format_error, path_or_stream, stream_name
from raylign.io.duplicates import Duplicates, resolve_duplicates
from raylign.scene import BalProblem

FORMAT_NAME = "raylign.BalProblem"
FORMAT_VERSION = 1

# dtype and columns (0 = one-dimensional) of each array; little-endian on every machine.
_MEMBERS: dict[str, tuple[str, int]] = {
    "cameras": ("<f8", 9),
    "points": ("<f8", 3),
    "camera_index": ("<i4", 0),
    "point_index": ("<i4", 0),
    "observations": ("<f8", 2),
    "colors": ("|u1", 3),
}
# Deflate cannot shrink more than this; a member that claims more is lying about its size.
_MAX_DEFLATE_RATIO = 1032
_SLACK = 1 << 16

# Whatever zipfile, zlib and NumPy's header parser raise on hostile bytes.
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    OSError,
    RuntimeError,
    ValueError,
)


def write_npz(problem: BalProblem, target: PathLike | BinaryIO) -> None:
    """Write every array of a problem, bit for bit, as a compressed `.npz` with a format version.

    Args:
        problem: not modified. Numbers that are not finite are kept.
        target: path, taken as it is (no suffix is added) and replaced only once the file is
            complete, or binary file object.

    Raises:
        FormatError: the target cannot be written.
        ShapeError: the arrays of `problem` disagree.
        TypeError: `target` is neither a path nor a binary file object.
    """
    problem.validate()
    resolved = path_or_stream(target)
    if not isinstance(resolved, str):
        _save(problem, resolved)
        return
    path = Path(resolved)
    temporary = path.with_name(f"{path.name}.tmp-{os.getpid()}")
    try:
        with temporary.open("xb") as stream:
            _save(problem, stream)
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        reason = f"cannot be written: {error.strerror or error}"
        raise format_error(resolved, "", reason) from error


def read_npz(source: PathLike | BinaryIO, *, duplicates: Duplicates = "error") -> BalProblem:
    """Read a problem written by `write_npz`.

    Args:
        source: path, or binary file object that can seek.
        duplicates: what to do when a camera sees a point twice, as in `read_bal`.

    Returns:
        BalProblem: equal to the one that was written, bit for bit, but for duplicates.

    Raises:
        FormatError: the source is missing, no zip archive, damaged, of another format or version;
            or an array is missing, has the wrong dtype, shape or memory order, holds Python objects
            (never unpickled) or indices out of range; or a camera sees a point twice.
        OptionsError: `duplicates` is none of the four.
        TypeError: `source` is neither a path nor a binary file object.
    """
    resolved = path_or_stream(source)
    name = resolved if isinstance(resolved, str) else stream_name(resolved)
    try:
        with zipfile.ZipFile(resolved) as archive:
            _check_format(archive, name)
            arrays = {
                key: _read_table(archive, name, key, dtype, columns)
                for key, (dtype, columns) in _MEMBERS.items()
            }
    except FormatError:
        raise
    except FileNotFoundError as error:
        raise format_error(name, "", f"cannot be opened: {error.strerror}") from error
    except IsADirectoryError as error:
        raise format_error(name, "", "is a directory") from error
    except _DAMAGED as error:
        raise format_error(name, "", f"is not a readable .npz archive: {error}") from error
    try:
        problem = BalProblem(**arrays)
    except ShapeError as error:
        raise format_error(name, "", str(error)) from error
    return resolve_duplicates(problem, duplicates=duplicates, name=name)


def _save(problem: BalProblem, stream: BinaryIO | IO[bytes]) -> None:
    np.savez_compressed(
        stream,
        format=np.array(FORMAT_NAME),
        version=np.array(FORMAT_VERSION, dtype="<i8"),
        **{key: problem.to_dict()[key].astype(dtype) for key, (dtype, _) in _MEMBERS.items()},
    )


def _check_format(archive: zipfile.ZipFile, name: str) -> None:
    kind = _read_member(archive, name, "format", f"<U{len(FORMAT_NAME)}", ())
    if kind.item() != FORMAT_NAME:
        raise format_error(name, "format", f"expected {FORMAT_NAME!r}, got {kind.item()!r}")
    version = _read_member(archive, name, "version", "<i8", ()).item()
    if version != FORMAT_VERSION:
        raise format_error(name, "version", f"this raylign reads {FORMAT_VERSION}, got {version}")


def _read_table(
    archive: zipfile.ZipFile, name: str, key: str, dtype: str, columns: int
) -> AnyArray:
    shape = (None, columns) if columns else (None,)
    array = _read_member(archive, name, key, dtype, shape)
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def _read_member(
    archive: zipfile.ZipFile, name: str, key: str, dtype: str, shape: tuple[int | None, ...]
) -> AnyArray:
    """Read one .npy member whose header is checked before anything of its size is allocated."""
    try:
        info = archive.getinfo(f"{key}.npy")
    except KeyError:
        raise format_error(name, key, "is missing") from None
    if info.file_size > _MAX_DEFLATE_RATIO * info.compress_size + _SLACK:
        raise format_error(name, key, "claims an impossible size")
    with archive.open(info) as stream:
        found_shape, fortran_order, found_dtype = _read_header(stream)
        if found_dtype != np.dtype(dtype):
            raise format_error(name, key, f"expected dtype {np.dtype(dtype)}, got {found_dtype}")
        fits = len(found_shape) == len(shape) and all(
            want is None or want == got for want, got in zip(shape, found_shape, strict=True)
        )
        if not fits or (fortran_order and len(found_shape) > 1):
            order = ", Fortran order" if fortran_order else ""
            raise format_error(name, key, f"has the wrong shape {found_shape}{order}")
        data = stream.read()
    expected = int(np.prod(found_shape, dtype=object)) * found_dtype.itemsize
    if len(data) != expected:
        raise format_error(name, key, f"holds {len(data)} bytes, its header needs {expected}")
    return np.frombuffer(data, dtype=found_dtype).reshape(found_shape)


def _read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    try:
        if np.lib.format.read_magic(stream) == (1, 0):
            return np.lib.format.read_array_header_1_0(stream)
        return np.lib.format.read_array_header_2_0(stream)
    except Exception as error:  # it evaluates a Python literal: tokenizer, syntax, dtype errors, …
        raise ValueError(f"array header: {error}") from error
