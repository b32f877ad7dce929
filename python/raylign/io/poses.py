"""World-to-camera poses, `poses.txt`: the columns of a TUM trajectory, but T_cw, one per image."""

from typing import BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

from raylign import geometry
from raylign._typing import F64, PathLike
from raylign.errors import ShapeError
from raylign.io._streams import format_error, write_atomically
from raylign.io._text import data_lines, read_text
from raylign.io.trajectory import tum_row


class StampedPoses(NamedTuple):
    """What `poses.txt` holds.

    Attributes:
        timestamps: (M,) float64, s; may be equal, and in any order.
        T_cw: (M, 4, 4) float64: maps points of the world into the camera.
    """

    timestamps: F64
    T_cw: F64


def read_poses(source: PathLike | BinaryIO) -> StampedPoses:
    r"""Read one pose T_cw per line, `timestamp tx ty tz qx qy qz qw`, in the order of the images.

    The columns are those of a TUM trajectory (`read_tum_trajectory`), which holds T_wc and strictly
    increasing stamps; here stamps may be equal, 0, or rounded to a day.

    Args:
        source: path, or binary file object, which is read to its end.

    Returns:
        StampedPoses: quaternions are normalised.

    Raises:
        FormatError: the file cannot be read or holds no pose; a line has not eight finite numbers,
            or a quaternion whose norm is off by more than 1 %. The error has `file`, `line`,
            `field` and `reason`.
        TypeError: `source` is neither a path nor a binary file object.

    Example:
        >>> import io
        >>> stamps, T_cw = read_poses(io.BytesIO(b"0 1 2 3 0 0 0 1\n0 4 5 6 0 0 0 1\n"))
        >>> stamps.tolist(), T_cw[1, :3, 3].tolist()
        ([0.0, 0.0], [4.0, 5.0, 6.0])
    """
    name, text = read_text(source)
    rows: list[list[float]] = []
    for line, content in data_lines(text):
        rows.append(tum_row(content, file=name, line=line))
    if not rows:
        raise format_error(name, "", "holds no pose")
    table = np.array(rows)
    return StampedPoses(table[:, 0].copy(), poses_from_tum(table[:, 1:]))


def write_poses(
    T_cw: npt.ArrayLike, target: PathLike | BinaryIO, *, timestamps: npt.ArrayLike | None = None
) -> None:
    """Write poses with as many digits as it takes to read them back.

    Args:
        T_cw: (M, 4, 4) rigid.
        target: path, replaced only once the file is complete, or binary file object.
        timestamps: (M,) s. Default: 0, 1, 2, …

    Raises:
        ShapeError: shapes disagree, or a number is not finite.
        FormatError: the target cannot be written.
        TypeError: `target` is neither a path nor a binary file object.
    """
    poses = np.asarray(T_cw, np.float64)
    stamps = np.arange(len(poses)) if timestamps is None else timestamps
    stamps = np.asarray(stamps, np.float64)
    if poses.shape != (len(poses), 4, 4) or stamps.shape != (len(poses),):
        raise ShapeError(
            f"T_cw must be (M, 4, 4) and timestamps (M,), got {poses.shape}, {stamps.shape}"
        )
    if not (np.isfinite(poses).all() and np.isfinite(stamps).all()):
        raise ShapeError("T_cw and timestamps must be finite")
    q = geometry.quaternion_from_matrix(np.ascontiguousarray(poses[:, :3, :3]))
    table = np.column_stack([stamps, poses[:, :3, 3], q])
    lines = [" ".join(map(repr, row)) + "\n" for row in table.tolist()]
    write_atomically(target, "".join(lines).encode())


def poses_from_tum(rows: F64) -> F64:
    """(M, 4, 4) of (M, 7) rows `tx ty tz qx qy qz qw`, the quaternions of any norm but 0."""
    T = np.tile(np.eye(4), (len(rows), 1, 1))
    T[:, :3, :3] = geometry.quaternion_to_matrix(np.ascontiguousarray(rows[:, 3:]))
    T[:, :3, 3] = rows[:, :3]
    return T
