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
    "ratio",
    "final cost",
    "iterations",
    "ns/obs/iteration",
    "ratio",
    "MB",
    "B/obs",
)


def seconds(value: float) -> str:
    """Three significant digits; – where it never happened."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def times(value: float | None) -> str:
    return "" if value is None or not math.isfinite(value) else f"{value:.1f}"


def cells(contest: dict, row: dict) -> list[str]:
    """`row` of a summarised contest, as COLUMNS name it."""
    key = row["system"]
    if "error" in row:
        return [key, row["error"]]
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
    ]


def title(contest: dict) -> str:
    return (
        f"{contest['problem']}: {contest['num_cameras']} cameras, {contest['num_points']} points, "
        f"{contest['num_observations']} observations; cost {contest['initial_cost']:.6g} -> "
        f"{contest['best_cost']:.9g}"
    )


def terminal_table(contest: dict) -> Table:
    table = Table(
        title=title(contest),
        caption="s to the start's excess over the best cost f* times 10 % ... 0.01 %, and to "
        f"1.001 f*; ratios to {OURS}, same threads, within a round; final cost: relative to f*",
    )
    for column in COLUMNS:
        table.add_column(column, justify="left" if column == "system" else "right")
    for row in contest["rows"]:
        if "error" in row:
            table.add_row(row["system"], *[""] * (len(COLUMNS) - 2), "failed")
        else:
            table.add_row(*cells(contest, row))
    return table


def markdown_table(contest: dict, keep: Callable[[str], bool] = lambda key: True) -> str:
    """The rows whose system `keep` takes."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|" + "---:|" * (len(COLUMNS) - 1)]
    for row in contest["rows"]:
        if keep(row["system"]):
            shown = cells(contest, row)
            shown += [""] * (len(COLUMNS) - len(shown))
            lines.append("| " + " | ".join(shown) + " |")
    return "\n".join(lines)
