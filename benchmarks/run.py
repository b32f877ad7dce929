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

The file is written after every contest and every other part; Ctrl-C keeps what was measured. What
fails is reported and left out, the rest goes on, and the exit status is 1 at the end.
"""

import argparse
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rich.console import Console

import guard
import import_time
import raylign
import render
from harness import contest as contests
from harness import machine, micro, problems, systems, tables
from harness.session import Session, fresh_target
from harness.ticker import Ticker

RESULTS = problems.ROOT / "benchmarks" / "results"
PARTS = (
    "contests",
    "jacobians",
    "reading",
    "reference_loops",
    "stages",
    "import",
    "rendering",
    "guard",
)
FAILURES = (subprocess.CalledProcessError, OSError, ValueError, LookupError, raylign.Error)
STOPPED = 130  # exit status after Ctrl-C


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=PARTS)
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


def chosen_systems(
    arguments: argparse.Namespace, tools: systems.Tools, spec: problems.Spec
) -> list[systems.System]:
    found = [system for system in systems.all_systems(tools) if system.suits(spec)]
    if arguments.systems:
        return [s for s in found if any(pattern in s.key for pattern in arguments.systems)]
    return found if arguments.all_systems else [s for s in found if s.is_default()]


def chosen_problems(arguments: argparse.Namespace) -> list[tuple[problems.Spec, int]]:
    """Problems and the rounds on each."""
    names = arguments.problems or (problems.names() if arguments.large else problems.DEFAULT)
    chosen = []
    for name in names:
        spec = problems.find_spec(name)
        if arguments.time_limit:
            spec = replace(spec, time_limit_s=arguments.time_limit)
        default = 3 if spec.num_observations <= problems.SMALL else 1
        chosen.append((spec, arguments.rounds or default))
    return chosen


def hold_contests(
    arguments: argparse.Namespace, tools: systems.Tools, session: Session, console: Console
) -> None:
    chosen = [
        (spec, rounds, chosen_systems(arguments, tools, spec))
        for spec, rounds in chosen_problems(arguments)
    ]
    total = sum(rounds * len(turn) for _, rounds, turn in chosen)
    with Ticker(console, total) as ticker:
        for spec, rounds, turn in chosen:
            try:
                hold_contest(spec, rounds, turn, tools, session, ticker, console)
            except FAILURES as error:
                session.errors[spec.name] = f"{type(error).__name__}: {error}"
                console.print(f"{spec.name} failed: {session.errors[spec.name]}", markup=False)
            session.save()


def hold_contest(
    spec: problems.Spec,
    rounds: int,
    turn: list[systems.System],
    tools: systems.Tools,
    session: Session,
    ticker: Ticker,
    console: Console,
) -> None:
    prepared = contests.prepare(spec, session.facts, rounds)
    if prepared is None:
        console.print(f"{spec.name}: its file is not at hand (set RAYLIGN_DATA)")
        ticker.skip(rounds * len(turn))
        return
    contest, problem = prepared
    session.contests.append(contest)
    contests.hold(contest, problem, spec, turn, tools, ticker.tell)
    print_contest(contest, console)


def print_contest(contest: dict, console: Console) -> None:
    shown = contests.summarize(contest)
    console.print(tables.terminal_table(shown))
    for note in tables.notes(shown):
        console.print(note, markup=False)


def measure_part(
    name: str, measure: Callable[[], object], session: Session, console: Console
) -> None:
    """One part into the session; what it raises becomes a message."""
    try:
        result = measure()
    except FAILURES as error:
        stderr = getattr(error, "stderr", None) or ""
        session.errors[name] = "\n".join([f"{type(error).__name__}: {error}", stderr]).strip()
        console.print(f"{name} failed: {session.errors[name]}", markup=False)
        return
    if result is not None:
        session.parts[name] = result
    session.save()


def main() -> int:
    arguments = parse_arguments()
    console = Console()
    if not console.is_terminal:
        console.width = 220
    facts = machine.facts()
    console.print(
        f"{facts['cpu']}, {facts['num_cpus']} CPUs, raylign {facts['raylign']} at {facts['commit']}"
    )
    target = arguments.output or fresh_target(RESULTS, facts["date"][:10])
    session = Session(target, facts, arguments.append)
    try:
        if arguments.programs is None:
            console.print(f"building the C++ programs in {machine.BUILD}")
        folder = arguments.programs or machine.build_programs()
        tools = systems.Tools(folder, arguments.peers)
        repeats = arguments.rounds or 5
        parts: dict[str, Callable[[], object]] = {
            "contests": lambda: hold_contests(arguments, tools, session, console),
            "jacobians": lambda: micro.bench_jacobians(folder, repeats, console),
            "reading": lambda: micro.bench_reading(repeats, console),
            "reference_loops": lambda: micro.bench_reference_loops(folder, console),
            "stages": lambda: micro.bench_stages(folder, console),
            "import": import_time.measure,
            "rendering": lambda: render.measure(repeats),
            "guard": lambda: guard.measure(repeats, folder),
        }
        for name in arguments.only or PARTS:
            measure_part(name, parts[name], session, console)
    except KeyboardInterrupt:
        kept = session.target if session.save() else "nothing"
        console.print(f"interrupted; kept: {kept}")
        return STOPPED
    console.print(f"written: {session.target}")
    return 1 if session.errors else 0


if __name__ == "__main__":
    sys.exit(main())
