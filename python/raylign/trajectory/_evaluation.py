"""Everything that `raylign evaluate` says about one trajectory."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from raylign.errors import Error
from raylign.trajectory._association import match
from raylign.trajectory._metrics import (
    KITTI_LENGTHS_M,
    AbsoluteError,
    Alignment,
    RelativeError,
    SegmentError,
    ate,
    coverage,
    rpe,
    segment_errors,
    short_lengths,
)
from raylign.trajectory._poses import Trajectory


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What `evaluate` returns.

    Attributes:
        alignment: what was removed before the comparison.
        scale: of the removed similarity; 1 unless `alignment` is SIM3.
        num_estimates: poses of the estimate.
        num_truth: poses of the truth.
        num_matched: pairs that were compared.
        coverage: share of the truth's poses with an estimate near in time, in [0, 1].
        path_length: of the truth over the pairs, m.
        duration_s: of the pairs, s.
        absolute: positions after alignment (ATE).
        per_frame: motion from each pair to the next (RPE).
        per_second: motion over one second (RPE); empty for shorter trajectories.
        segments: drift over parts of the path; empty for paths shorter than the lengths.
    """

    alignment: Alignment
    scale: float
    num_estimates: int
    num_truth: int
    num_matched: int
    coverage: float
    path_length: float
    duration_s: float
    absolute: AbsoluteError
    per_frame: RelativeError
    per_second: RelativeError
    segments: tuple[SegmentError, ...]

    def to_dict(self) -> dict[str, Any]:
        """Every number, without the per-pose lists: for JSON. Lengths in m, angles in rad."""
        return {
            "alignment": self.alignment.value,
            "scale": self.scale,
            "S_te": self.absolute.S_te.tolist(),
            "num_estimates": self.num_estimates,
            "num_truth": self.num_truth,
            "num_matched": self.num_matched,
            "coverage": self.coverage,
            "path_length": self.path_length,
            "duration_s": self.duration_s,
            "ate": _both(self.absolute),
            "rpe_per_frame": _both(self.per_frame),
            "rpe_per_second": _both(self.per_second),
            "segments": [vars(segment) for segment in self.segments],
        }


def evaluate(
    estimate: Trajectory,
    truth: Trajectory,
    *,
    alignment: Alignment = Alignment.SE3,
    max_difference_s: float = 0.02,
    offset_s: float = 0.0,
    interpolate: bool = False,
    segment_lengths: Sequence[float] | None = KITTI_LENGTHS_M,
    segment_step: int = 10,
) -> Evaluation:
    """Compare an estimated trajectory with the truth.

    Args:
        estimate: stamped poses, in any world.
        truth: stamped poses on the same clock, up to `offset_s`.
        alignment: what is removed before the comparison.
        max_difference_s: largest difference of paired stamps, s, see `match`.
        offset_s: added to the estimate's stamps, s.
        interpolate: take the truth at the estimate's times, see `match`.
        segment_lengths: m, see `segment_errors`; None: 10 to 80 % of the path, for short paths.
        segment_step: poses between the starts of segments.

    Raises:
        Error: no stamps agree, or the alignment is not determined (see `align`).
        OptionsError: a setting is out of range.

    Example:
        >>> time = np.linspace(0, 2, 61)
        >>> t = np.column_stack([time, np.sin(time), np.cos(time)])
        >>> truth = Trajectory.from_quaternions(time, t, np.tile([0, 0, 0, 1.0], (61, 1)))
        >>> result = evaluate(truth[:31].shifted(0.001), truth)
        >>> result.num_matched, round(result.coverage, 2), result.absolute.translation.rmse < 1e-12
        (31, 0.51, True)
    """
    paired, true = match(
        estimate,
        truth,
        max_difference_s=max_difference_s,
        offset_s=offset_s,
        interpolate=interpolate,
    )
    if len(paired) == 0:
        raise Error(_no_match_message(estimate, truth, max_difference_s))
    lengths = short_lengths(true) if segment_lengths is None else segment_lengths
    absolute = ate(paired, true, mode=alignment)
    scale = float(np.cbrt(np.linalg.det(absolute.S_te[:3, :3])))
    if alignment is not Alignment.SIM3:
        scale = 1.0  # to the last bit
    return Evaluation(
        alignment=alignment,
        scale=scale,
        num_estimates=len(estimate),
        num_truth=len(truth),
        num_matched=len(paired),
        coverage=coverage(estimate, truth, max_difference_s=max_difference_s, offset_s=offset_s),
        path_length=true.path_length(),
        duration_s=true.duration_s(),
        absolute=absolute,
        per_frame=rpe(paired, true, scale=scale),
        per_second=rpe(paired, true, delta_s=1.0, scale=scale),
        segments=tuple(
            segment_errors(paired, true, lengths=lengths, step=segment_step, scale=scale)
        ),
    )


def _both(error: AbsoluteError | RelativeError) -> dict[str, Any]:
    return {
        "translation_m": error.translation.to_dict(),
        "rotation_rad": error.rotation.to_dict(),
    }


def _no_match_message(estimate: Trajectory, truth: Trajectory, max_difference_s: float) -> str:
    """Say what the clocks look like: milliseconds or frame numbers are the usual mistake."""

    def span(trajectory: Trajectory) -> str:
        if len(trajectory) == 0:
            return "is empty"
        t = trajectory.timestamps
        return f"runs from {t[0]:.6f} to {t[-1]:.6f} s"

    return (
        f"no pose of the estimate lies within {max_difference_s:g} s of the truth: the estimate "
        f"{span(estimate)}, the truth {span(truth)}; check the unit of the stamps and the offset"
    )
