"""What a results file says over problem sizes: the best variant of each peer, fits, ratios."""

import math
from dataclasses import dataclass

import numpy as np

from harness import contest as contests

PEERS = ("autodiff", "analytic", "pycolmap", "gtsam")
NOT_RUN = "not run"


def family_of(row: dict) -> str:
    return str(row["system"]).split(" ")[0]


def version(held: list[dict], family: str) -> str:
    """As a family's workers name themselves, up to the first colon; empty: none finished."""
    messages = (
        row["message"]
        for contest in held
        for row in contest["rows"]
        if family_of(row) == family and "error" not in row
    )
    return next(messages, "").split(":")[0]


def label(held: list[dict], family: str) -> str:
    """A system by name, with the versions that were measured."""
    ceres = version(held, "autodiff") or "Ceres"
    names = {
        "native": "raylign native",
        "analytic": f"raylign through {ceres}",
        "autodiff": f"{ceres}, autodiff",
    }
    return names.get(family) or version(held, family) or family


def find_row(contest: dict, key: str) -> dict | None:
    """A summary row that did not fail."""
    return next((r for r in contest["rows"] if r["system"] == key and "error" not in r), None)


def rows_of(contest: dict, family: str, threads: int) -> list[dict]:
    """Every variant of a family on so many threads, failures included."""
    return [
        row
        for row in contest["rows"]
        if family_of(row) == family and row["system"].endswith(f"x{threads}")
    ]


def why_never(contest: dict, family: str, threads: int) -> str:
    """Why no variant of a family came within 0.1 % of the best cost."""
    rows = rows_of(contest, family, threads)
    if not rows:
        return NOT_RUN
    ends = {row.get("ended", "") for row in rows if "error" not in row}
    # the least of the rounds' limits: nobody knows which of them this system was part of
    limits = min(contest.get("measured", []), key=lambda entry: entry["time_limit_s"], default=None)
    if limits is not None and "time limit" in ends:
        return f"not in {limits['time_limit_s']:g} s"
    if limits is not None and "limit of iterations" in ends:
        return f"not in {limits['max_iterations']} iterations"
    if "tolerance" in ends:
        return "ended above"
    return "not within its limits" if ends else "failed"


def best_variant(contest: dict, family: str, threads: int) -> dict | None:
    """The row of `family` that is first within 0.1 % of the best cost."""
    rows = [
        row
        for row in rows_of(contest, family, threads)
        if "error" not in row and math.isfinite(row["times_to"][-1])
    ]
    return min(rows, key=lambda row: row["times_to"][-1], default=None)


def native(contest: dict, threads: int) -> dict | None:
    """The automatic choice: what a user gets."""
    return find_row(contest, f"native auto x{threads}")


def row_of(contest: dict, family: str, threads: int) -> dict | None:
    if family == "native":
        return native(contest, threads)
    return best_variant(contest, family, threads)


@dataclass(frozen=True)
class Comparison:
    """One peer's best variant against the native engine, ratios > 1: native is better."""

    system: str
    counts_otherwise: bool  # got there by a cost of its own
    time: float | None  # to 0.1 % above the best cost
    iteration: float | None  # ns per observation and iteration
    memory: float | None  # peak beyond the imports


def compare(contest: dict, family: str, threads: int) -> Comparison | None:
    theirs, ours = best_variant(contest, family, threads), native(contest, threads)
    if theirs is None or ours is None:
        return None
    n = contest["num_observations"]
    pair = (contest, theirs["system"], ours["system"])
    return Comparison(
        theirs["system"],
        contests.counts_otherwise(theirs),
        contests.ratio(*pair, contests.headline_time),
        contests.ratio(*pair, lambda r: contests.judge.ns_per_observation_and_iteration(r, n)),
        contests.ratio(*pair, lambda run: run["peak_bytes"] - run["baseline_bytes"]),
    )


def kind_of(contest: dict) -> str:
    """`street`, `orbit`, or the collection of a real problem."""
    return str(contest["problem"]).split("-")[0]


def by_size(held: list[dict], kind: str) -> list[dict]:
    chosen = [contest for contest in held if kind_of(contest) == kind]
    return sorted(chosen, key=lambda contest: contest["num_observations"])


def seconds_per_iteration(held: list[dict], kind: str, threads: int) -> np.ndarray:
    """(observations, s per Levenberg-Marquardt iteration) of the native engine."""
    pairs = []
    for contest in by_size(held, kind):
        row = native(contest, threads)
        if row is not None:
            n = contest["num_observations"]
            pairs.append((n, 1e-9 * n * row["ns_per_observation_and_iteration"]))
    return np.array(pairs).reshape(-1, 2)


def growth_exponent(pairs: np.ndarray) -> float:
    """Slope of log time over log observations: 1 is linear growth."""
    return float(np.polyfit(np.log(pairs[:, 0]), np.log(pairs[:, 1]), 1)[0])
