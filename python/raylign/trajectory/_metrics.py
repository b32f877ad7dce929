"""How far an estimated trajectory is from the truth: ATE, RPE, KITTI segments, coverage."""

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from raylign import geometry
from raylign._typing import F64, I32
from raylign.errors import Error, OptionsError, ShapeError
from raylign.trajectory._poses import Trajectory

KITTI_LENGTHS_M = (100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0)


class Alignment(enum.Enum):
    """What is removed from an estimate before it is compared with the truth."""

    NONE = "none"
    """Nothing: both share a world."""
    FIRST_POSE = "first_pose"
    """The rigid transform that makes the first pair of poses equal."""
    SE3 = "se3"
    """The rigid transform that fits the positions best (Umeyama)."""
    SIM3 = "sim3"
    """The similarity that fits the positions best: estimates without a scale."""


@dataclass(frozen=True, eq=False)
class ErrorStatistics:
    """Numbers of a list of errors, all in its unit; NaN for an empty list.

    Attributes:
        values: (N,) float64, the errors, >= 0.
    """

    values: F64

    @property
    def rmse(self) -> float:
        """√(mean of squares)."""
        return float(np.sqrt(np.mean(self.values**2))) if len(self.values) else np.nan

    @property
    def mean(self) -> float:
        """Arithmetic mean."""
        return float(np.mean(self.values)) if len(self.values) else np.nan

    @property
    def median(self) -> float:
        """Half are larger."""
        return float(np.median(self.values)) if len(self.values) else np.nan

    @property
    def max(self) -> float:
        """Largest."""
        return float(np.max(self.values)) if len(self.values) else np.nan

    def to_dict(self) -> dict[str, float]:
        """The numbers without the list."""
        return {
            "rmse": self.rmse, "mean": self.mean, "median": self.median, "max": self.max,
            "count": len(self.values),
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class AbsoluteError:
    """What `ate` returns.

    Attributes:
        translation: ‖p_true − p_estimated‖ of each pair, in the truth's unit (m).
        rotation: angle between the rotations of each pair, rad.
        S_te: (4, 4) similarity from the estimate's world to the truth's that was removed.
        estimate: (N poses) the estimate in the truth's world.
        truth: (N poses) the truth.
    """

    translation: ErrorStatistics
    rotation: ErrorStatistics
    S_te: F64
    estimate: Trajectory
    truth: Trajectory


@dataclass(frozen=True, eq=False)
class RelativeError:
    """What `rpe` returns.

    Attributes:
        translation: ‖t‖ of each E, in the truth's unit (m).
        rotation: angle of each E, rad.
        pairs: (K, 2) int32 indices of the poses i, j that each E spans.
    """

    translation: ErrorStatistics
    rotation: ErrorStatistics
    pairs: I32


@dataclass(frozen=True)
class SegmentError:
    """Drift over path segments of one length, as in the KITTI odometry benchmark.

    Attributes:
        length: of the segments along the truth, m.
        num_segments: how many.
        translation: mean of ‖t‖ / length: 0.01 is 1 %.
        rotation: mean of angle / length, rad per m.
    """

    length: float
    num_segments: int
    translation: float
    rotation: float


def align(estimate: Trajectory, truth: Trajectory, *, mode: Alignment = Alignment.SE3) -> F64:
    """S_te that takes the estimate's world to the truth's.

    Args:
        estimate: N poses.
        truth: the N poses that belong to them (see `match`).
        mode: which transform.

    Returns:
        (4, 4) [sR t; 0 1].

    Raises:
        ShapeError: the numbers of poses differ, or are 0 (SE3, SIM3: less than 3).
        Error: SE3 or SIM3 and the positions lie on one line or in one place: they determine no
            rotation. `FIRST_POSE` has an answer then.
    """
    _check_pair("align", estimate, truth)
    if mode is Alignment.NONE:
        return np.eye(4)
    if mode is Alignment.FIRST_POSE:
        return np.asarray(truth.T_wc[0] @ geometry.se3_inverse(estimate.T_wc[0]))
    try:
        return geometry.umeyama(
            np.ascontiguousarray(estimate.positions),
            np.ascontiguousarray(truth.positions),
            with_scale=mode is Alignment.SIM3,
        )
    except ShapeError:
        raise ShapeError(f"align: {mode.value} needs at least 3 poses, got {len(truth)}") from None
    except Error as error:
        raise Error(
            f"align: the {len(truth)} positions lie on one line or in one place and determine no "
            f"rotation; align by the first pose or not at all ({error})"
        ) from None


def ate(
    estimate: Trajectory, truth: Trajectory, *, mode: Alignment = Alignment.SE3
) -> AbsoluteError:
    """Absolute trajectory error: distances between positions after alignment.

    Args:
        estimate: N poses.
        truth: the N poses that belong to them (see `match`).
        mode: what is removed first.

    Raises:
        ShapeError, Error: as `align`.

    Source: Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012, §V.B.

    Example:
        >>> angle = np.linspace(0, 3, 50)
        >>> t = np.column_stack([np.cos(angle), np.sin(angle), 0.1 * angle])
        >>> truth = Trajectory.from_quaternions(angle, t, np.tile([0, 0, 0, 1.0], (50, 1)))
        >>> moved = truth.transformed(geometry.se3_exp([5, 6, 7, 0.1, 0.2, 0.3]))
        >>> ate(moved, truth).translation.rmse < 1e-12
        True
    """
    S_te = align(estimate, truth, mode=mode)
    aligned = estimate.transformed(S_te)
    distance = np.linalg.norm(truth.positions - aligned.positions, axis=1)
    R_error = np.swapaxes(truth.T_wc[:, :3, :3], 1, 2) @ aligned.T_wc[:, :3, :3]
    return AbsoluteError(
        ErrorStatistics(distance), ErrorStatistics(_angles(R_error)), S_te, aligned, truth
    )


def rpe(
    estimate: Trajectory,
    truth: Trajectory,
    *,
    delta_frames: int | None = None,
    delta_s: float | None = None,
    scale: float = 1.0,
) -> RelativeError:
    """Relative pose error: E = (Q_i⁻¹ Q_j)⁻¹ (P_i⁻¹ P_j), truth Q, estimate P, for every i.

    Alignment does not matter, except for a scale. Errors over `delta_s` are those of the motion
    between the two poses, not divided by their exact distance in time.

    Args:
        estimate: N poses.
        truth: the N poses that belong to them (see `match`).
        delta_frames: j = i + delta_frames, >= 1; the default is 1.
        delta_s: j is the pose nearest in time to t_i + delta_s, if it is no farther than half a
            median period (and 5 % of it: stamps jitter).
        scale: of an estimate without one, e.g. the cube root of det `S_te[:3, :3]`.

    Raises:
        ShapeError: the numbers of poses differ, or are 0.
        OptionsError: both deltas are given, or one is out of range.

    Source: Sturm et al., IROS 2012, §V.A; as in the TUM tools, with `delta_s` = 1 called the drift
    per second.
    """
    _check_pair("rpe", estimate, truth)
    if delta_s is not None:
        if delta_frames is not None or not 0.0 < delta_s < np.inf:
            raise OptionsError("rpe: give delta_frames >= 1 or delta_s > 0, not both")
        pairs = _pairs_in_time(truth, delta_s)
    else:
        step = 1 if delta_frames is None else delta_frames
        if step < 1:
            raise OptionsError(f"rpe: delta_frames must be >= 1, got {step}")
        first = np.arange(max(len(truth) - step, 0))
        pairs = np.column_stack([first, first + step])
    E = _pair_errors(estimate, truth, pairs, scale)
    return RelativeError(
        ErrorStatistics(np.linalg.norm(E[:, :3, 3], axis=1)),
        ErrorStatistics(_angles(E[:, :3, :3])),
        pairs.astype(np.int32),
    )


def segment_errors(
    estimate: Trajectory,
    truth: Trajectory,
    *,
    lengths: Sequence[float] = KITTI_LENGTHS_M,
    step: int = 10,
    scale: float = 1.0,
) -> list[SegmentError]:
    """Mean drift over segments of the path, per length, as in the KITTI odometry benchmark.

    A segment starts at every `step`-th pose and ends at the first pose whose distance along the
    truth is more than the length away.

    Args:
        estimate: N poses.
        truth: the N poses that belong to them (see `match`).
        lengths: of the segments, m, > 0; for short paths see `short_lengths`.
        step: poses between starts, >= 1.
        scale: of an estimate without one.

    Returns:
        One row per length that the path is long enough for.

    Raises:
        ShapeError: the numbers of poses differ, or are 0.
        OptionsError: a length or the step is out of range.

    Source: Geiger et al., Are we ready for Autonomous Driving?, CVPR 2012, and its devkit.
    """
    _check_pair("segment_errors", estimate, truth)
    if step < 1 or not all(0.0 < length < np.inf for length in lengths):
        raise OptionsError("segment_errors: step must be >= 1 and lengths finite and > 0")
    distances = truth.distances()
    starts = np.arange(0, len(truth), step)
    rows = []
    for length in lengths:
        ends = np.searchsorted(distances, distances[starts] + length, side="right")
        inside = ends < len(truth)
        if not inside.any():
            continue
        pairs = np.column_stack([starts[inside], ends[inside]])
        E = _pair_errors(estimate, truth, pairs, scale)
        translation = float(np.mean(np.linalg.norm(E[:, :3, 3], axis=1))) / length
        rotation = float(np.mean(_angles(E[:, :3, :3]))) / length
        rows.append(SegmentError(float(length), len(pairs), translation, rotation))
    return rows


def short_lengths(truth: Trajectory) -> tuple[float, ...]:
    """KITTI's eight lengths, 1/8 to 8/8, scaled so that the longest is 80 % of the path."""
    total = 0.8 * truth.path_length()
    return tuple(total * length / KITTI_LENGTHS_M[-1] for length in KITTI_LENGTHS_M if total > 0)


def coverage(
    estimate: Trajectory,
    truth: Trajectory,
    *,
    max_difference_s: float = 0.02,
    offset_s: float = 0.0,
) -> float:
    """Share of the truth's poses that have an estimate near in time, in [0, 1].

    Near is `max_difference_s` or half the estimate's median period, whichever is more: a truth of
    100 Hz is covered by images of 30 Hz. A run that dies early has a low error and a low coverage.
    """
    if len(truth) == 0 or len(estimate) == 0:
        return 0.0
    limit = max(max_difference_s, 0.5 * estimate.median_period_s())
    stamps = estimate.timestamps + offset_s
    right = np.searchsorted(stamps, truth.timestamps).clip(0, len(stamps) - 1)
    left = (right - 1).clip(0)
    gap = np.minimum(abs(stamps[right] - truth.timestamps), abs(stamps[left] - truth.timestamps))
    return float(np.mean(gap <= limit * (1.0 + 1e-9)))


def _check_pair(function: str, estimate: Trajectory, truth: Trajectory) -> None:
    if len(estimate) != len(truth) or len(truth) == 0:
        raise ShapeError(
            f"{function}: {len(estimate)} poses against {len(truth)}; both must have the same "
            "number, at least one (see match)"
        )


def _pairs_in_time(truth: Trajectory, delta_s: float) -> Any:
    t = truth.timestamps
    right = np.searchsorted(t, t + delta_s).clip(0, len(t) - 1)
    left = (right - 1).clip(0)
    nearer = np.where(abs(t[left] - t - delta_s) < abs(t[right] - t - delta_s), left, right)
    limit = 0.55 * truth.median_period_s()
    keep = (abs(t[nearer] - t - delta_s) <= limit) & (nearer > np.arange(len(t)))
    return np.column_stack([np.flatnonzero(keep), nearer[keep]])


def _pair_errors(estimate: Trajectory, truth: Trajectory, pairs: Any, scale: float) -> F64:
    i, j = pairs[:, 0], pairs[:, 1]
    relative = geometry.se3_inverse(estimate.T_wc[i]) @ estimate.T_wc[j]
    relative[:, :3, 3] *= scale
    true = geometry.se3_inverse(truth.T_wc[i]) @ truth.T_wc[j]
    return np.asarray(geometry.se3_inverse(true) @ relative)


def _angles(R: F64) -> F64:
    return np.asarray(np.linalg.norm(geometry.so3_log(np.ascontiguousarray(R)), axis=-1))
