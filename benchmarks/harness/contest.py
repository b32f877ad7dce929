"""Systems in turns over a problem, and what the turns say: medians, and ratios within a turn."""

import math
import statistics
from collections.abc import Callable, Iterable

from harness import judge, systems
from harness.problems import Spec, find_file
from harness.systems import System, Tools

ENDS = {"tolerance": "tolerance", "time": "time limit", "max": "limit of iterations"}


def prepare(spec: Spec, facts: dict, rounds: int) -> tuple[dict, judge.Problem] | None:
    """A contest without runs, and its problem; None where the problem's file is not at hand."""
    path = find_file(spec.name)
    if path is None:
        return None
    problem = judge.read_problem(path)
    contest = {
        "problem": spec.name,
        "num_cameras": len(problem.cameras),
        "num_points": len(problem.points),
        "num_observations": len(problem.pixels),
        "initial_cost": judge.cost(problem, problem.cameras, problem.points),
        "measured": [
            {
                "commit": facts["commit"],
                "date": facts["date"],
                "rounds": rounds,
                "max_iterations": spec.max_iterations,
                "time_limit_s": spec.time_limit_s,
            }
        ],
        "runs": [],
    }
    return contest, problem


def hold(
    contest: dict,
    problem: judge.Problem,
    spec: Spec,
    chosen: list[System],
    tools: Tools,
    tell: Callable[[str], None],
) -> None:
    """Run every system once per round into `contest`; what failed once is not tried again."""
    rounds = contest["measured"][-1]["rounds"]
    failed: set[str] = set()
    for number in range(rounds):
        for system in chosen:
            tell(f"{spec.name}: {system.key}, round {number + 1}/{rounds}")
            if system.key in failed:
                continue
            run = systems.run(system, tools, spec, problem)
            contest["runs"].append({"round": number, **run})
            if "error" in run:
                failed.add(system.key)


def merge(first: dict, second: dict) -> dict:
    """Two contests of one problem as one; the rounds of the second count on."""
    offset = 1 + max((run["round"] for run in first["runs"]), default=-1)
    later = [{**run, "round": run["round"] + offset} for run in second["runs"]]
    return {
        **first,
        "measured": first.get("measured", []) + second.get("measured", []),
        "runs": first["runs"] + later,
    }


def end_of(run: dict) -> str:
    """Why a run ended, in the same words for every system; each has its own in `message`."""
    text = run.get("message", "").lower()
    return next((end for word, end in ENDS.items() if word in text), "")


def finished(contest: dict) -> list[dict]:
    return [run for run in contest["runs"] if "error" not in run]


def summarize(contest: dict) -> dict:
    """Adds `best_cost` and one row per system to a contest: medians over its rounds."""
    runs = finished(contest)
    best = min((run["judged_cost"] for run in runs), default=math.nan)
    goals = judge.targets(contest["initial_cost"], best)
    for run in runs:
        run["times_to"] = [judge.time_to(run["trace"], goal) for goal in goals]
    keys = dict.fromkeys(run["system"] for run in contest["runs"])
    rows = [summary_row(key, contest, best) for key in keys]
    return {**contest, "best_cost": best, "rows": rows}


def summary_row(key: str, contest: dict, best: float) -> dict:
    runs = [run for run in finished(contest) if run["system"] == key]
    if not runs:
        failed = next(run for run in contest["runs"] if run["system"] == key)
        return {"system": key, "error": failed["error"]}
    n = contest["num_observations"]

    def median(values: Iterable[float]) -> float:
        return statistics.median(values)

    memory = median(run["peak_bytes"] - run["baseline_bytes"] for run in runs)
    return {
        "system": key,
        "rounds": len(runs),
        "parse_s": median(run["parse_s"] for run in runs),
        "build_s": median(run["build_s"] for run in runs),
        "preprocess_s": median(run["preprocess_s"] for run in runs),
        "solve_s": median(run["solve_s"] for run in runs),
        "times_to": [median(times) for times in zip(*(r["times_to"] for r in runs), strict=True)],
        "iterations": median(len(run["trace"]) - 1 for run in runs),
        "ns_per_observation_and_iteration": median(
            judge.ns_per_observation_and_iteration(run, n) for run in runs
        ),
        "memory_bytes": memory,
        "memory_bytes_per_observation": memory / n,
        "excess": median(run["judged_cost"] for run in runs) / best - 1.0,
        "linear_solver": runs[0].get("linear_solver", ""),
        "ended": end_of(runs[0]),
        "message": runs[0].get("message", ""),
    }


def counts_otherwise(row: dict) -> bool:
    """Whether a system reached f* by its own cost and not by the judge's: it drops observations."""
    return (
        "error" not in row
        and math.isfinite(row["times_to"][-1])
        and row["excess"] > 2.0 * (judge.STRICT - 1.0)
    )


def headline_time(run: dict) -> float:
    """Seconds to 0.1 % above the best cost."""
    return run["times_to"][-1]


def ratio(contest: dict, baseline: str, ours: str, value: Callable[[dict], float]) -> float | None:
    """Median over the rounds that both finished of value(baseline) / value(ours)."""
    by_round: dict[int, dict[str, dict]] = {}
    for run in finished(contest):
        by_round.setdefault(run["round"], {})[run["system"]] = run
    pairs = [
        value(turn[baseline]) / value(turn[ours])
        for turn in by_round.values()
        if baseline in turn and ours in turn and math.isfinite(value(turn[ours]))
    ]
    return statistics.median(pairs) if pairs else None
