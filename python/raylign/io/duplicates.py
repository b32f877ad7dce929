"""What to do when a camera observes the same point more than once."""

from typing import Literal, get_args

import numpy as np

from raylign._typing import AnyArray
from raylign.errors import OptionsError
from raylign.io._streams import format_error
from raylign.scene import BalProblem

Duplicates = Literal["error", "first", "mean", "keep"]


def resolve_duplicates(
    problem: BalProblem, *, duplicates: Duplicates = "error", name: str = "<memory>"
) -> BalProblem:
    """Apply the policy of `read_bal` to a problem in memory, with the same bits as its result.

    Args:
        problem: not modified.
        duplicates: refuse (`error`), keep the `first`, the `mean` pixel in the place of the first,
            or `keep` all (they then count twice in the cost).
        name: stands for the file in messages.

    Returns:
        BalProblem: `problem` itself where there is nothing to change.

    Raises:
        FormatError: `error`, and some camera observes a point twice.
        OptionsError: `duplicates` is none of the four.
        ShapeError: the arrays of `problem` disagree.
    """
    if duplicates not in get_args(Duplicates):
        raise OptionsError(f"duplicates must be error, first, mean or keep, got '{duplicates}'")
    problem.validate()
    if duplicates == "keep":
        return problem
    first, repeat = _repeats(problem)
    if len(repeat) == 0:
        return problem
    if duplicates == "error":
        i = int(repeat[0])
        raise format_error(
            name,
            f"observation {i}",
            f"repeats camera {problem.camera_index[i]}, point {problem.point_index[i]} of "
            f"observation {first[0]}; choose duplicates = first, mean or keep to read it all "
            "the same",
        )
    observations = problem.observations.copy()
    if duplicates == "mean":
        _average_into_first(observations, first, repeat)
    keep = np.ones(problem.num_observations, dtype=bool)
    keep[repeat] = False
    return problem.replace(
        camera_index=problem.camera_index[keep],
        point_index=problem.point_index[keep],
        observations=observations[keep],
    )


def _repeats(problem: BalProblem) -> tuple[AnyArray, AnyArray]:
    """Indices of the first observation of a pair, and of its repeats in ascending order."""
    pair = problem.camera_index.astype(np.int64) * problem.num_points + problem.point_index
    _, first, inverse = np.unique(pair, return_index=True, return_inverse=True)
    first_of = first[inverse]
    repeat = np.flatnonzero(first_of != np.arange(len(pair)))
    return first_of[repeat], repeat


def _average_into_first(observations: AnyArray, first: AnyArray, repeat: AnyArray) -> None:
    counts: dict[int, float] = {}  # running mean: no overflow of a sum
    for i, j in zip(first.tolist(), repeat.tolist(), strict=True):
        count = counts[i] = counts.get(i, 1.0) + 1.0
        observations[i] += observations[j] / count - observations[i] / count
