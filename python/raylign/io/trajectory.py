"""Trajectories as TUM (`t x y z qx qy qz qw`) and KITTI (12 numbers of [R t]) text."""

from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from raylign._typing import F64, PathLike
from raylign.errors import OptionsError, ShapeError
from raylign.io._streams import format_error, write_atomically
from raylign.io._text import data_lines, numbers, read_text
from raylign.trajectory import Trajectory

_TUM_FIELDS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
_KITTI_FIELDS = tuple(f"T{row}{column}" for row in range(3) for column in range(4))

# Four digits, as TUM's own files have, put a quaternion's norm off by 1e-4; a wrong column by more.
_QUATERNION_TOLERANCE = 1e-2
_ROTATION_TOLERANCE = 1e-3  # on |RᵀR − I| of a file; then the nearest rotation is taken
_EXACT = 1e-9  # a matrix this good is kept bit for bit
_KITTI_RATE_HZ = 10.0


def read_tum_trajectory(source: PathLike | BinaryIO) -> Trajectory:
    r"""Read stamped poses T_wc: one line `timestamp tx ty tz qx qy qz qw` each, s, m, `#` comments.

    Args:
        source: path, or binary file object, which is read to its end.

    Returns:
        Trajectory: quaternions are normalised.

    Raises:
        FormatError: the file cannot be read or holds no pose; a line has not eight finite numbers,
            a quaternion whose norm is off by more than 1 %, or a stamp that is not later than the
            one before. The error has `file`, `line`, `field` and `reason`.
        TypeError: `source` is neither a path nor a binary file object.

    Source: TUM RGB-D benchmark, file formats.

    Example:
        >>> import io
        >>> read_tum_trajectory(io.BytesIO(b"# stamp pose\n0.5 1 2 3 0 0 0 1\n")).positions
        array([[1., 2., 3.]])
    """
    name, text = read_text(source)
    rows: list[list[float]] = []
    for line, content in data_lines(text):
        row = tum_row(content, file=name, line=line)
        if rows and row[0] <= rows[-1][0]:
            reason = f"must be later than the stamp before, {rows[-1][0]!r}, got {row[0]!r}"
            raise format_error(name, "timestamp", reason, line=line)
        rows.append(row)
    if not rows:
        raise format_error(name, "", "holds no pose")
    table = np.array(rows)
    return Trajectory.from_quaternions(table[:, 0], table[:, 1:4], table[:, 4:])


def write_tum_trajectory(trajectory: Trajectory, target: PathLike | BinaryIO) -> None:
    """Write stamped poses in the TUM format, with as many digits as it takes to read them back.

    Args:
        trajectory: stamps in s, T_wc.
        target: path, replaced only once the file is complete, or binary file object.

    Raises:
        FormatError: the target cannot be written.
        TypeError: `target` is neither a path nor a binary file object.
    """
    table = np.column_stack([trajectory.timestamps, trajectory.positions, trajectory.quaternions])
    lines = ["# timestamp tx ty tz qx qy qz qw", *map(_row, table.tolist())]
    write_atomically(target, ("\n".join(lines) + "\n").encode())


def read_kitti_poses(
    source: PathLike | BinaryIO, *, timestamps: npt.ArrayLike | None = None
) -> Trajectory:
    """Read poses T_wc in KITTI's odometry format: the 12 numbers of [R t] row by row.

    Args:
        source: path, or binary file object, which is read to its end.
        timestamps: (N,) s, e.g. of KITTI's `times.txt`; the default is 10 Hz from 0.

    Returns:
        Trajectory: a rotation rounded in the file is replaced by the nearest exact one.

    Raises:
        FormatError: the file cannot be read or holds no pose; a line has not twelve finite numbers
            or no rotation. The error has `file`, `line`, `field` and `reason`.
        ShapeError: there are not as many `timestamps` as poses.
        TypeError: `source` is neither a path nor a binary file object.
    """
    name, text = read_text(source)
    poses: list[F64] = []
    for line, content in data_lines(text):
        T_wc = np.eye(4)
        T_wc[:3] = np.reshape(numbers(content, _KITTI_FIELDS, file=name, line=line), (3, 4))
        R = nearest_rotation(T_wc[:3, :3])
        if R is None:
            raise format_error(name, "", "the 3x3 part is no rotation", line=line)
        T_wc[:3, :3] = R
        poses.append(T_wc)
    if not poses:
        raise format_error(name, "", "holds no pose")
    if timestamps is None:
        timestamps = np.arange(len(poses)) / _KITTI_RATE_HZ
    stamps = np.asarray(timestamps, np.float64)
    if stamps.shape != (len(poses),):
        raise ShapeError(f"{name} holds {len(poses)} poses, timestamps are {stamps.shape}")
    try:
        return Trajectory(stamps, np.array(poses))
    except OptionsError as error:
        raise OptionsError(f"{name}: {error}") from None


def write_kitti_poses(trajectory: Trajectory, target: PathLike | BinaryIO) -> None:
    """Write poses T_wc as KITTI's 12 numbers a line; reading gives every bit. Stamps are lost.

    Args:
        trajectory: T_wc.
        target: path, replaced only once the file is complete, or binary file object.

    Raises:
        FormatError: the target cannot be written.
        TypeError: `target` is neither a path nor a binary file object.
    """
    rows = trajectory.T_wc[:, :3].reshape(-1, 12).tolist()
    write_atomically(target, "".join(_row(row) + "\n" for row in rows).encode())


def nearest_rotation(M: F64) -> F64 | None:
    """The rotation nearest to a 3x3 matrix that is one up to rounding; None if it is not."""
    if not np.isfinite(M).all():
        return None
    error = float(np.abs(M.T @ M - np.eye(3)).max())
    if error > _ROTATION_TOLERANCE or np.linalg.det(M) < 0.0:
        return None
    if error <= _EXACT:
        return M
    U, _, V_t = np.linalg.svd(M)
    return np.asarray(U @ V_t)


def tum_row(content: str, *, file: str, line: int) -> list[float]:
    """The eight numbers of a line, the quaternion last, which is of unit norm up to rounding.

    Raises:
        FormatError: they are not.
    """
    row = numbers(content, _TUM_FIELDS, file=file, line=line)
    norm = float(np.linalg.norm(row[4:]))
    if not abs(norm - 1.0) <= _QUATERNION_TOLERANCE:
        reason = f"a unit quaternion is expected, its norm is {norm:.6g}"
        raise format_error(file, "qx qy qz qw", reason, line=line)
    return row


def _row(values: list[float]) -> str:
    return " ".join(map(repr, values))
