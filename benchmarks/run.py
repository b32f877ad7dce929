"""Benchmarks: builds the C++ programs, runs everything, prints tables, writes JSON.

    make bench
    .venv/bin/python benchmarks/run.py --peers peers/bin/python    # with the wheels of peers.txt
    .venv/bin/python benchmarks/run.py --only contests --problems street-250-65000 \\
        --systems "native auto" "autodiff sparse" --rounds 5
    .venv/bin/python benchmarks/run.py --only contests --large     # to five million observations

A contest is a problem that all systems solve in turns, each in a process of its own; the final
costs are computed by one judge (harness/judge.py). Ratios are taken within a round, because a
shared machine drifts. --append adds the rounds to a results file: long series can be
measured in pieces. Made problems are kept in benchmarks/.cache ($RAYLIGN_BENCH_CACHE).
"""

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from harness import contest as contests
from harness import machine, micro, problems, systems, tables
from import_time import measure as measure_import

RESULTS = problems.ROOT / "benchmarks" / "results"
PARTS = ("contests", "jacobians", "reading", "reference_loops", "stages", "import")


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", choices=PARTS)
    parser.add_argument("--problems", nargs="+", choices=problems.names(), metavar="NAME")
    parser.add_argument("--large", action="store_true", help="every problem: hours")
    parser.add_argument("--systems", nargs="+", help="only those whose key contains one of these")
    parser.add_argument("--all-systems", action="store_true", help="every variant of every system")
    parser.add_argument(
        "--peers", type=Path, help="interpreter with benchmarks/peers.txt installed"
    )
    parser.add_argument("--rounds", type=int, help="default: 3 where a solve takes seconds, else 1")
    parser.add_argument("--time-limit", type=float, help="seconds a solve may take, for all alike")
    parser.add_argument("--programs", type=Path, help="folder of built programs; default: build")
    parser.add_argument("--output", type=Path, help="default: benchmarks/results/<date>.json")
    parser.add_argument("--append", action="store_true", help="add the rounds to --output")
    return parser.parse_args()


def chosen_systems(arguments: argparse.Namespace, tools: systems.Tools) -> list[systems.System]:
    found = systems.all_systems(tools)
    if arguments.systems:
        return [s for s in found if any(pattern in s.key for pattern in arguments.systems)]
    return found if arguments.all_systems else [s for s in found if s.is_default()]


def hold_contests(
    arguments: argparse.Namespace, tools: systems.Tools, console: Console
) -> list[dict]:
    names = arguments.problems or (problems.names() if arguments.large else problems.DEFAULT)
    held = []
    for name in names:
        spec = problems.find_spec(name)
        if arguments.time_limit:
            spec = replace(spec, time_limit_s=arguments.time_limit)
        rounds = arguments.rounds or (3 if spec.num_observations <= problems.SMALL else 1)
        with console.status(name) as status:
            result = contests.hold(
                spec, chosen_systems(arguments, tools), tools, rounds, status.update
            )
        if result is None:
            console.print(f"{name}: its file is not at hand (set RAYLIGN_DATA)")
            continue
        result = contests.summarize(result)
        console.print(tables.terminal_table(result))
        for row in result["rows"]:
            if "error" in row:
                console.print(f"{row['system']}: {row['error']}", markup=False)
        held.append(result)
    return held


def append_contests(old: list[dict], new: list[dict]) -> list[dict]:
    """The contests of a results file with later ones: rounds of the same problem are joined."""
    merged = {contest["problem"]: contest for contest in old}
    for contest in new:
        earlier = merged.get(contest["problem"])
        joined = contest if earlier is None else contests.merge(earlier, contest)
        merged[contest["problem"]] = contests.summarize(joined)
    return list(merged.values())


def write_results(arguments: argparse.Namespace, facts: dict, results: dict) -> Path:
    target = arguments.output or RESULTS / f"{facts['date'][:10]}.json"
    if arguments.append and target.exists():
        earlier = json.loads(target.read_text())["results"]
        if "contests" in results:
            results["contests"] = append_contests(earlier.get("contests", []), results["contests"])
        results = {**earlier, **results}
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps({"machine": facts, "results": results}, indent=1) + "\n")
    return target


def main() -> int:
    arguments = parse_arguments()
    console = Console()
    if not console.is_terminal:
        console.width = 220
    facts = machine.facts()
    console.print(
        f"{facts['cpu']}, {facts['num_cpus']} CPUs, raylign {facts['raylign']} at {facts['commit']}"
    )
    folder = arguments.programs or machine.build_programs()
    tools = systems.Tools(folder, arguments.peers)
    parts = {
        "contests": lambda: hold_contests(arguments, tools, console),
        "jacobians": lambda: micro.bench_jacobians(folder, arguments.rounds or 5, console),
        "reading": lambda: micro.bench_reading(arguments.rounds or 5, console),
        "reference_loops": lambda: micro.bench_reference_loops(folder, console),
        "stages": lambda: micro.bench_stages(folder, console),
        "import": measure_import,
    }
    chosen = [arguments.only] if arguments.only else list(parts)
    target = write_results(arguments, facts, {name: parts[name]() for name in chosen})
    console.print(f"written: {target}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
