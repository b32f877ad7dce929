"""A camera's path: stamped poses."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from raylign import geometry
from raylign._typing import F64, Bool
from raylign.errors import OptionsError, ShapeError

_ROTATION_TOLERANCE = 1e-6  # on |RᵀR − I|; files with fewer digits are normalised by their readers


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses over time.

    Attributes:
        timestamps: (N,) float64, s, finite, strictly increasing.
        T_wc: (N, 4, 4) float64, rigid: maps points of the camera (or body) frame to the world.

    The arrays are copied in and read-only. `len`, `==` and slices (`trajectory[10:50:2]`, masks,
    index arrays in increasing order) work; `trajectory[i]` is (timestamp, T_wc).

    Raises:
        ShapeError: shapes disagree.
        OptionsError: stamps do not increase, a number is not finite, or a pose is not rigid.

    Example:
        >>> T_wc = geometry.se3_exp([[0, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0], [3, 0, 0, 0, 0, 0]])
        >>> path = Trajectory([0.0, 0.5, 1.0], T_wc)
        >>> len(path), path.path_length()
        (3, 3.0)
    """

    timestamps: F64
    T_wc: F64

    def __init__(self, timestamps: npt.ArrayLike, T_wc: npt.ArrayLike) -> None:
        object.__setattr__(self, "timestamps", _frozen(timestamps, "timestamps"))
        object.__setattr__(self, "T_wc", _frozen(T_wc, "T_wc"))
        self._check()

    @classmethod
    def from_quaternions(
        cls, timestamps: npt.ArrayLike, t_wc: npt.ArrayLike, q_wc: npt.ArrayLike
    ) -> "Trajectory":
        """Build from positions (N, 3) and quaternions xyzw (N, 4), not zero, of any norm."""
        t, q = np.asarray(t_wc, np.float64), np.asarray(q_wc, np.float64)
        T_wc = np.tile(np.eye(4), (len(t), 1, 1))
        T_wc[:, :3, :3] = geometry.quaternion_to_matrix(q)
        T_wc[:, :3, 3] = t
        return cls(timestamps, T_wc)

    def __len__(self) -> int:
        return len(self.timestamps)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, int | np.integer):
            return float(self.timestamps[key]), self.T_wc[key].copy()
        return Trajectory(self.timestamps[key], self.T_wc[key])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Trajectory):
            return NotImplemented
        return np.array_equal(self.timestamps, other.timestamps) and np.array_equal(
            self.T_wc, other.T_wc
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        if len(self) == 0:
            return "<Trajectory: empty>"
        return (
            f"<Trajectory: {len(self)} poses, {self.duration_s():.6g} s, "
            f"path {self.path_length():.6g}>"
        )

    @property
    def positions(self) -> F64:
        """(N, 3) camera centres in the world."""
        return self.T_wc[:, :3, 3]

    @property
    def quaternions(self) -> F64:
        """(N, 4) unit quaternions xyzw of the rotations, w >= 0."""
        return geometry.quaternion_from_matrix(np.ascontiguousarray(self.T_wc[:, :3, :3]))

    def duration_s(self) -> float:
        """Time from the first pose to the last, s."""
        return float(self.timestamps[-1] - self.timestamps[0]) if len(self) else 0.0

    def distances(self) -> F64:
        """(N,) length of the path up to each pose, in the unit of the positions."""
        steps = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        return np.concatenate([np.zeros(min(len(self), 1)), np.cumsum(steps)])

    def path_length(self) -> float:
        """Length of the path, in the unit of the positions."""
        return float(self.distances()[-1]) if len(self) else 0.0

    def median_period_s(self) -> float:
        """Median time between neighbouring poses, s; 0 for fewer than two."""
        return float(np.median(np.diff(self.timestamps))) if len(self) > 1 else 0.0

    def shifted(self, offset_s: float) -> "Trajectory":
        """The same poses, every stamp later by `offset_s`."""
        return Trajectory(self.timestamps + offset_s, self.T_wc)

    def transformed(self, S_nw: npt.ArrayLike) -> "Trajectory":
        """The same path seen from another world.

        Args:
            S_nw: (4, 4) similarity [sR t; 0 1] (s = 1: rigid) from this world to the new one.
                Positions become s R p + t, rotations R R_wc: poses stay rigid.
        """
        S = np.asarray(S_nw, np.float64)
        if S.shape != (4, 4):
            raise ShapeError(f"S_nw must be (4, 4), got {S.shape}")
        scale = np.cbrt(np.linalg.det(S[:3, :3]))
        T_nc = self.T_wc.copy()
        T_nc[:, :3, :3] = S[:3, :3] / scale @ self.T_wc[:, :3, :3]
        T_nc[:, :3, 3] = self.positions @ S[:3, :3].T + S[:3, 3]
        return Trajectory(self.timestamps, T_nc)

    def interpolate(self, timestamps: npt.ArrayLike, *, max_gap_s: float = np.inf) -> "Trajectory":
        """Poses at other times, between the two neighbours of each.

        Positions move on straight lines, rotations at constant angular velocity (slerp). Times
        outside the trajectory, or between poses more than `max_gap_s` apart, have no pose and are
        left out: compare the result's `timestamps`, or use `interpolable`.

        Args:
            timestamps: (M,) s, strictly increasing.
            max_gap_s: longest interval to interpolate over, s.
        """
        t = _frozen(timestamps, "timestamps")
        t = t[self.interpolable(t, max_gap_s=max_gap_s)]
        right = np.searchsorted(self.timestamps, t, side="left")
        left = np.where(self.timestamps[right] == t, right, right - 1) if len(t) else right
        span = self.timestamps[right] - self.timestamps[left]
        alpha = np.divide(t - self.timestamps[left], span, out=np.zeros_like(t), where=span > 0)
        R_left = np.ascontiguousarray(self.T_wc[left, :3, :3])
        turn = geometry.so3_log(np.swapaxes(R_left, 1, 2) @ self.T_wc[right, :3, :3])
        T_wc = np.tile(np.eye(4), (len(t), 1, 1))
        T_wc[:, :3, :3] = R_left @ geometry.so3_exp(alpha[:, None] * turn)
        p = self.positions
        T_wc[:, :3, 3] = p[left] + alpha[:, None] * (p[right] - p[left])
        return Trajectory(t, T_wc)

    def interpolable(self, timestamps: npt.ArrayLike, *, max_gap_s: float = np.inf) -> Bool:
        """(M,) where `interpolate` has an answer."""
        t = np.asarray(timestamps, np.float64)
        right = np.searchsorted(self.timestamps, t, side="left")
        last = len(self) - 1
        exact = (
            (right <= last) & (self.timestamps[np.minimum(right, last)] == t)
            if len(self)
            else (np.zeros(t.shape, bool))
        )
        between = (right > 0) & (right <= last)
        index = np.clip(right, 1, max(last, 1))
        if last < 1:
            return np.asarray(exact)
        gap = self.timestamps[index] - self.timestamps[index - 1]
        return np.asarray(exact | (between & (gap <= max_gap_s)))

    def _check(self) -> None:
        t, T = self.timestamps, self.T_wc
        if t.ndim != 1 or T.shape != (len(t), 4, 4):
            raise ShapeError(
                "Trajectory: timestamps must be (N,) and T_wc (N, 4, 4), got "
                f"{t.shape} and {T.shape}"
            )
        if not (np.isfinite(t).all() and np.isfinite(T).all()):
            raise OptionsError("Trajectory: timestamps and T_wc must be finite")
        late = np.flatnonzero(np.diff(t) <= 0)
        if len(late):
            i = int(late[0])
            raise OptionsError(
                f"Trajectory.timestamps must be strictly increasing, got {float(t[i + 1])!r} after "
                f"{float(t[i])!r} at index {i + 1}"
            )
        bad = np.flatnonzero(~_is_rigid(T))
        if len(bad):
            raise OptionsError(f"Trajectory.T_wc must be rigid transforms, pose {bad[0]} is not")


def _is_rigid(T: F64) -> Bool:
    R = T[:, :3, :3]
    error = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2), initial=0.0)
    bottom = (T[:, 3] == [0.0, 0.0, 0.0, 1.0]).all(axis=1)
    return np.asarray((error < _ROTATION_TOLERANCE) & (np.linalg.det(R) > 0) & bottom)


def _frozen(values: npt.ArrayLike, name: str) -> F64:
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ShapeError(f"{name} must be real numbers: {error}") from error
    array.setflags(write=False)
    return array
