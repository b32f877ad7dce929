"""Write the tables of the documentation and its figures from a results file.

    .venv/bin/python benchmarks/report.py benchmarks/results/2026-11-22.json

Whatever stands between `<!-- begin NAME -->` and `<!-- end NAME -->` in docs/benchmarks.md is
replaced by the table NAME; prose around it is written by hand.
"""

import argparse
import json
import re
from collections.abc import Callable
from pathlib import Path

from harness import plots, series, tables
from harness.problems import ROOT

DOCUMENT = ROOT / "docs" / "benchmarks.md"
IMAGES = ROOT / "docs" / "images"
BLOCK = re.compile(r"(<!-- begin (\S+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def markdown(header: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|---|" + "---:|" * (len(header) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def headline_table(held: list[dict], threads: int) -> str:
    """Time to 0.1 % above the best cost, and ratios of each peer's best variant to ours."""
    header = ["problem", "raylign native, s"]
    header += [f"{series.LABELS[family]}: time, iteration, memory" for family in series.PEERS]
    rows = []
    for contest in held:
        ours = series.native(contest, threads)
        if ours is None:
            continue
        row = [contest["problem"], tables.seconds(ours["times_to"][-1])]
        for family in series.PEERS:
            found = series.compare(contest, family, threads)
            ratios = (found.time, found.iteration, found.memory) if found else ()
            row.append(" / ".join(tables.times(value) for value in ratios) or "–")
        rows.append(row)
    return markdown(header, rows)


def native_table(held: list[dict]) -> str:
    header = ["problem", "observations", "linear solver", "preprocess, ns/obs"]
    header += ["iteration, ns/obs", "two threads", "B/obs", "final cost to best"]
    rows = []
    for contest in held:
        one, two = (series.native(contest, threads) for threads in (1, 2))
        if one is None:
            continue
        n = contest["num_observations"]
        rate = "ns_per_observation_and_iteration"
        rows.append(
            [
                contest["problem"],
                str(n),
                one["linear_solver"].split(":")[0],
                f"{1e9 * one['preprocess_s'] / n:.0f}",
                f"{one[rate]:.0f}",
                "" if two is None else f"{one[rate] / two[rate]:.2f}x",
                f"{one['memory_bytes_per_observation']:.0f}",
                f"{one['excess']:+.0e}",
            ]
        )
    return markdown(header, rows)


def growth_table(held: list[dict]) -> str:
    header = ["scene", "threads", "from", "to", "time per iteration grows as"]
    rows = []
    for kind, name in plots.KINDS.items():
        for threads in (1, 2):
            pairs = series.seconds_per_iteration(held, kind, threads)
            pairs = pairs[pairs[:, 0] >= 30_000]
            if len(pairs) >= 2:
                exponent = f"N^{series.growth_exponent(pairs):.2f}"
                ends = [f"{pairs[0, 0]:.0f}", f"{pairs[-1, 0]:.0f}"]
                rows.append([name, str(threads), *ends, exponent])
    return markdown(header, rows)


def machine_line(machine: dict) -> str:
    return (
        f"{machine['cpu']}, {machine['num_cpus']} CPUs, {machine['memory_gib']} GiB, "
        f"{machine['system']}, Python {machine['python']}, raylign {machine['raylign']} at commit "
        f"{machine['commit']}, {machine['date'][:10]}."
    )


def blocks(data: dict) -> dict[str, Callable[[], str]]:
    """Name of a block to what makes its text."""
    results = data["results"]
    held = results.get("contests", [])
    made: dict[str, Callable[[], str]] = {
        "machine": lambda: machine_line(data["machine"]),
        "headline-1": lambda: headline_table(held, 1),
        "headline-2": lambda: headline_table(held, 2),
        "native": lambda: native_table(held),
        "growth": lambda: growth_table(held),
    }
    for contest in held:
        made[f"contest:{contest['problem']}"] = lambda c=contest: tables.markdown_table(c)
    return made


def rewrite(text: str, made: dict[str, Callable[[], str]]) -> str:
    """The document with every known block replaced; unknown ones stay as they are."""

    def replace(match: re.Match[str]) -> str:
        name = match[2]
        return f"{match[1]}{made[name]()}\n{match[3]}" if name in made else match[0]

    return BLOCK.sub(replace, text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    data = json.loads(parser.parse_args().results.read_text())
    DOCUMENT.write_text(rewrite(DOCUMENT.read_text(), blocks(data)))
    for path in plots.save_all(data["results"].get("contests", []), IMAGES):
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
