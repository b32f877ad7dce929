"""Systems in turns over a problem, and what the turns say: medians, and ratios within a turn."""

import math
import statistics
from collections.abc import Callable, Iterable

from harness import judge, systems
from harness.problems import Spec, find_file
from harness.systems import System, Tools


def hold(
    spec: Spec, chosen: list[System], tools: Tools, rounds: int, tell: Callable[[str], None]
) -> dict | None:
    """Run every system once per round; None where the problem's file is not at hand."""
    path = find_file(spec.name)
    if path is None:
        return None
    problem = judge.read_problem(path)
    runs = []
    for round_number in range(rounds):
        for system in chosen:
            if system.suits(len(problem.cameras)):
                tell(f"{spec.name}: {system.key}, round {round_number + 1}/{rounds}")
                runs.append({"round": round_number, **systems.run(system, tools, spec, problem)})
    return {
        "problem": spec.name,
        "num_cameras": len(problem.cameras),
        "num_points": len(problem.points),
        "num_observations": len(problem.pixels),
        "initial_cost": judge.cost(problem, problem.cameras, problem.points),
        "runs": runs,
    }


def merge(first: dict, second: dict) -> dict:
    """Two contests of one problem as one; the rounds of the second count on."""
    offset = 1 + max((run["round"] for run in first["runs"]), default=-1)
    later = [{**run, "round": run["round"] + offset} for run in second["runs"]]
    return {**first, "runs": first["runs"] + later}


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
        "message": runs[0].get("message", ""),
    }


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
