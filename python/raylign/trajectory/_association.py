"""Which stamps of one list belong to which of another."""

import numpy as np
import numpy.typing as npt

from raylign._typing import F64, I32
from raylign.errors import OptionsError, ShapeError
from raylign.trajectory._poses import Trajectory

_OFFSET_ITERATIONS = 20


def associate(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    *,
    max_difference_s: float = 0.02,
    offset_s: float = 0.0,
) -> I32:
    """Pair two lists of stamps: one-to-one, in the same order, as many pairs as there can be.

    Among the pairings with the most pairs, the one with the smallest Σ |first + offset − second|
    is taken. Picking the nearest stamp for each, as is usual, uses a stamp twice and jumps between
    two neighbours where the lists lie half a period apart (TUM fr1: −15 and +17 ms).

    Args:
        first: (N,) s, strictly increasing.
        second: (M,) s, strictly increasing.
        max_difference_s: largest |first + offset − second| of a pair, s, > 0.
        offset_s: added to `first`, s.

    Returns:
        (K, 2) int32 indices into `first` and `second`, both columns increasing.

    Raises:
        ShapeError: a list is not one-dimensional.
        OptionsError: stamps do not increase or are not finite; a setting is out of range.

    Note: takes O(P log M) for P pairs of stamps within the limit.

    Example:
        >>> associate([0.0, 0.1, 0.2], [0.01, 0.11, 0.35]).tolist()
        [[0, 0], [1, 1]]
    """
    a, b = _stamps(first, "first"), _stamps(second, "second")
    if not 0.0 < max_difference_s < np.inf or not np.isfinite(offset_s):
        raise OptionsError(
            "associate: max_difference_s must be finite and > 0 and offset_s finite, got "
            f"{max_difference_s} and {offset_s}"
        )
    a = a + offset_s
    low = np.searchsorted(b, a - max_difference_s, side="left")
    high = np.searchsorted(b, a + max_difference_s, side="right")
    if np.all(high - low <= 1) and len(np.unique(low[high > low])) == np.sum(high > low):
        rows = np.flatnonzero(high > low)  # nobody has a choice
        return np.column_stack([rows, low[rows]]).astype(np.int32)
    return _best_chain(a, b, low.tolist(), high.tolist())


def estimate_time_offset(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    *,
    near_s: float = 0.0,
    max_difference_s: float = 0.05,
) -> float:
    """Median of second − first over the pairs of the mode of the differences next to `near_s`.

    Where two sensors run at one rate but apart, the differences between the stamps pile up at some
    lag. Starting from `near_s`, pairs within half a period of the lag are made and the lag moved to
    their median until it rests: every pair then comes from the same side. Stamps say nothing about
    which pile is right when there are two (one period apart): `near_s` chooses.

    Args:
        first: (N,) s, strictly increasing.
        second: (M,) s, strictly increasing.
        near_s: where to start, s.
        max_difference_s: largest distance of the result from `near_s`, s.

    Returns:
        `offset_s` for `associate`, s; `near_s` where no pair is found.

    Raises:
        ShapeError, OptionsError: as `associate`.

    Example:
        >>> import numpy as np
        >>> color = np.arange(10) / 30
        >>> round(estimate_time_offset(color, color - 0.015), 6)
        -0.015
    """
    a, b = _stamps(first, "first"), _stamps(second, "second")
    if len(a) < 2 or len(b) < 2:
        return near_s
    # Half a period, and a little less: a stamp may not fall to either side of the lag.
    window = 0.495 * float(np.median(np.diff(b)))
    offset = near_s
    for _ in range(_OFFSET_ITERATIONS):
        pairs = associate(a, b, max_difference_s=window, offset_s=offset)
        if len(pairs) == 0:
            return near_s
        moved = float(np.median(b[pairs[:, 1]] - a[pairs[:, 0]]))
        if moved == offset:
            break
        offset = moved
    return offset if abs(offset - near_s) <= max_difference_s else near_s


def match(
    estimate: Trajectory,
    truth: Trajectory,
    *,
    max_difference_s: float = 0.02,
    offset_s: float = 0.0,
    interpolate: bool = False,
) -> tuple[Trajectory, Trajectory]:
    """Poses of two trajectories that belong together.

    Args:
        estimate: poses to judge.
        truth: poses to judge them by.
        max_difference_s: largest difference of the stamps in a pair, s; with `interpolate`, half
            the longest gap of the truth that is interpolated over.
        offset_s: added to the estimate's stamps, s.
        interpolate: take the truth at the estimate's very times (straight lines, slerp) instead of
            its nearest pose. Removes the error of the stamps' difference where the truth is dense;
            evo and the TUM tools do not.

    Returns:
        Two trajectories of one length with the truth's stamps (with `interpolate`, the
        estimate's plus the offset).

    Raises:
        OptionsError: a setting is out of range.
    """
    if interpolate:
        shifted = estimate.shifted(offset_s)
        keep = truth.interpolable(shifted.timestamps, max_gap_s=2.0 * max_difference_s)
        stamps = shifted.timestamps[keep]
        return shifted[keep], truth.interpolate(stamps, max_gap_s=2.0 * max_difference_s)
    pairs = associate(
        estimate.timestamps,
        truth.timestamps,
        max_difference_s=max_difference_s,
        offset_s=offset_s,
    )
    true = truth[pairs[:, 1]]
    return Trajectory(true.timestamps, estimate.T_wc[pairs[:, 0]]), true


def _stamps(values: npt.ArrayLike, name: str) -> F64:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise ShapeError(f"associate: {name} must be (N,), got {array.shape}")
    if not np.isfinite(array).all() or (np.diff(array) <= 0).any():
        raise OptionsError(f"associate: {name} must be finite and strictly increasing")
    return array


def _best_chain(a: F64, b: F64, low: list[int], high: list[int]) -> I32:
    """Longest chain of pairs with both indices increasing; of these, the least Σ |a − b|.

    Row by row, each pair extends the best chain that ends in a smaller column; a Fenwick tree
    over the columns holds the best chain up to each.
    """
    nothing = (0, 0.0, -1)  # pairs in the chain, −Σ |a − b|, its last node
    tree = [nothing] * (len(b) + 1)
    nodes: list[tuple[int, int, int]] = []  # row, column, node before
    for row in range(len(a)):
        found = []
        for column in range(low[row], high[row]):
            best = nothing
            i = column
            while i > 0:
                best = max(best, tree[i])
                i -= i & -i
            found.append((best[0] + 1, best[1] - abs(float(a[row] - b[column])), len(nodes)))
            nodes.append((row, column, best[2]))
        for chain in found:  # entered only now: a row takes part in a chain once
            i = nodes[chain[2]][1] + 1
            while i <= len(b):
                tree[i] = max(tree[i], chain)
                i += i & -i
    best = nothing
    i = len(b)
    while i > 0:
        best = max(best, tree[i])
        i -= i & -i
    return _walk_back(nodes, best[2])


def _walk_back(nodes: list[tuple[int, int, int]], last: int) -> I32:
    pairs = []
    while last >= 0:
        row, column, last = nodes[last]
        pairs.append((row, column))
    return np.array(pairs[::-1], dtype=np.int32).reshape(-1, 2)
