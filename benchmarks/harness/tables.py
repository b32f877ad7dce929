"""One table per problem, for the terminal and, the same cells, for docs/benchmarks.md."""

import math
from collections.abc import Callable

from rich.table import Table

from harness import contest as contests

OURS = "native auto"  # what ratios are against, with the same number of threads
COLUMNS = (
    "system",
    "read s",
    "build s",
    "preprocess s",
    "10 %",
    "1 %",
    "0.1 %",
    "0.01 %",
    "0.1 % of f*",
    "times ours",
    "final cost",
    "iterations",
    "ns/obs/iteration",
    "times ours",
    "MB",
    "B/obs",
    "ended by",
)


def seconds(value: float) -> str:
    """Three significant digits; – where it never happened."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def times(value: float | None) -> str:
    return "" if value is None or not math.isfinite(value) else f"{value:.1f}"


def cells(contest: dict, row: dict) -> list[str]:
    """`row` of a summarised contest, as COLUMNS name it; what failed has a note beside."""
    key = row["system"]
    if "error" in row:
        return [key, *["–"] * (len(COLUMNS) - 2), "failed"]
    ours = f"{OURS} x{key[-1]}"

    def against_ours(value: Callable[[dict], float]) -> str:
        return "" if key == ours else times(contests.ratio(contest, key, ours, value))

    n = contest["num_observations"]
    return [
        key,
        seconds(row["parse_s"]),
        seconds(row["build_s"]),
        seconds(row["preprocess_s"]),
        *(seconds(value) for value in row["times_to"]),
        against_ours(contests.headline_time),
        f"{row['excess']:+.0e}",
        f"{row['iterations']:.0f}",
        f"{row['ns_per_observation_and_iteration']:.0f}",
        against_ours(lambda run: contests.judge.ns_per_observation_and_iteration(run, n)),
        f"{row['memory_bytes'] / 1e6:.0f}",
        f"{row['memory_bytes_per_observation']:.0f}",
        row.get("ended", ""),
    ]


def facts(contest: dict) -> str:
    return (
        f"{contest['num_cameras']} cameras, {contest['num_points']} points, "
        f"{contest['num_observations']} observations; cost from {contest['initial_cost']:.6g} to "
        f"f* = {contest['best_cost']:.9g}."
    )


def terminal_table(contest: dict) -> Table:
    table = Table(
        title=f"{contest['problem']}: {facts(contest)}",
        caption="s to the start's excess over the best cost f* times 10 % ... 0.01 %, and to "
        f"1.001 f*; ratios to {OURS}, same threads, within a round; final cost: relative to f*",
    )
    for column in COLUMNS:
        table.add_column(column, justify="left" if column == "system" else "right")
    for row in contest["rows"]:
        table.add_row(*cells(contest, row))
    return table


def notes(contest: dict) -> list[str]:
    """What the table has no column for: failures, restarts, costs that are not the judge's."""
    found = []
    for row in contest["rows"]:
        if "error" in row:
            found.append(f"{row['system']} failed: {row['error']}")
        elif " restarts" in row["message"] and " 0 restarts" not in row["message"]:
            found.append(f"{row['system']}: {row['message']}")
        if contests.counts_otherwise(row):
            found.append(
                f"{row['system']}: ended within 0.1 % of f* by its own cost, "
                f"{row['excess']:+.0e} from it by the judge's; its times are to its own"
            )
    return found


def markdown_table(contest: dict) -> str:
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|" + "---:|" * (len(COLUMNS) - 1)]
    lines += ["| " + " | ".join(cells(contest, row)) + " |" for row in contest["rows"]]
    lines += [f"\n{sentence}" for sentence in (*origin(contest), *notes(contest))]
    return "\n".join(lines)


def origin(contest: dict) -> list[str]:
    """Where and within which limits the rounds of a contest were measured."""
    return [
        f"{entry['rounds']} round{'s' * (entry['rounds'] > 1)} at commit {entry['commit']}, "
        f"at most {entry['max_iterations']} iterations or {entry['time_limit_s']:g} s a solve."
        for entry in contest.get("measured", [])
    ]
