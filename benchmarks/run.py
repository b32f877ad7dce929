"""End-to-end benchmarks: builds the C++ programs, runs everything, prints tables, writes JSON.

    make bench      # or: .venv/bin/python benchmarks/run.py [--repeats 5] [--only NAME]

Ratios are taken pair by pair within one process run, because a shared machine drifts;
docs/benchmarks.md quotes the medians.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import raylign
from import_time import measure as measure_import

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "bench"
RESULTS = ROOT / "benchmarks" / "results"
SHARED = Path(os.environ.get("RAYLIGN_DATA", ROOT.parent / "shared" / "data"))


def build_programs() -> Path:
    """Configure and build the C++ benchmark programs; return their folder."""
    flags = [
        "-DRAYLIGN_BUILD_BENCHMARKS=ON",
        "-DRAYLIGN_BUILD_TESTS=OFF",
        "-DCMAKE_BUILD_TYPE=Release",
    ]
    subprocess.run(
        ["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", *flags],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    subprocess.run(
        ["cmake", "--build", BUILD, "--target", "bal_benchmark"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return BUILD / "benchmarks" / "micro"


def machine_facts() -> dict:
    cpu = next(
        (
            line.split(":")[1].strip()
            for line in Path("/proc/cpuinfo").read_text().splitlines()
            if "model name" in line
        ),
        platform.processor(),
    )
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True
    )
    return {
        "cpu": cpu,
        "num_cpus": os.cpu_count(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "raylign": raylign.__version__,
        "commit": commit.stdout.strip() or "unknown",
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def bal_files() -> list[Path]:
    """The real problems where they are at hand, the shipped ones always."""
    real = [SHARED / "bal" / f"problem-{name}-pre.txt" for name in ("49-7776", "21-11315")]
    return [
        *(path for path in real if path.is_file()),
        *(ROOT / "data" / "bal" / f"{scene}.txt.gz" for scene in ("street", "orbit")),
    ]


def short_name(path: Path) -> str:
    """`problem-49-7776-pre.txt` → `49-7776`: what a column has room for."""
    return (
        path.name.removesuffix(".gz")
        .removesuffix(".txt")
        .removeprefix("problem-")
        .removesuffix("-pre")
    )


def run_bal_program(folder: Path, path: Path, *flags: str) -> list[dict]:
    output = subprocess.run(
        [folder / "bal_benchmark", path, *flags], check=True, capture_output=True, text=True
    )
    return [json.loads(line) for line in output.stdout.splitlines()]


def values(rows: list[dict], system: str, pose: str, field: str) -> list[float]:
    """One number per repeat."""
    return [row[field] for row in rows if (row["system"], row["pose"]) == (system, pose)]


def median_ratio(
    rows: list[dict], field: str, baseline: tuple[str, str], ours: tuple[str, str]
) -> float:
    """Median over the repeats of baseline / ours, each a (system, pose)."""
    pairs = zip(values(rows, *baseline, field), values(rows, *ours, field), strict=True)
    return statistics.median(a / b for a, b in pairs)


def bench_jacobians(folder: Path, repeats: int, console: Console) -> list[dict]:
    """Analytic against automatic differentiation through the same Ceres, one thread."""
    table = Table(
        title="Jacobians, dense_schur, 1 thread: median ns/observation, ratio autodiff / raylign"
    )
    for column in (
        "problem",
        "Ceres autodiff",
        "raylign se3",
        "ratio",
        "raylign angle_axis",
        "ratio",
    ):
        table.add_column(column, justify="left" if column == "problem" else "right")
    results = []
    for path in bal_files():
        rows = run_bal_program(folder, path, "--repeats", str(repeats))
        field = "jacobian_ns_per_observation"

        ratios = {
            pose: median_ratio(
                rows, field, ("ceres_autodiff", "angle_axis"), ("raylign_ceres", pose)
            )
            for pose in ("se3", "angle_axis")
        }
        table.add_row(
            short_name(path),
            f"{statistics.median(values(rows, 'ceres_autodiff', 'angle_axis', field)):.0f}",
            f"{statistics.median(values(rows, 'raylign_ceres', 'se3', field)):.0f}",
            f"{ratios['se3']:.2f}",
            f"{statistics.median(values(rows, 'raylign_ceres', 'angle_axis', field)):.0f}",
            f"{ratios['angle_axis']:.2f}",
        )
        results.append({"problem": path.name, "ratios": ratios, "rows": rows})
    console.print(table)
    return results


def time_to_cost(row: dict, target: float) -> float:
    """Seconds since the call until the cost was at most `target`; inf when it never was."""
    return next((seconds for seconds, cost in row["trace"] if cost <= target), float("inf"))


def bench_native(folder: Path, repeats: int, console: Console) -> list[dict]:
    """The native engine against Ceres, autodiff and analytic: dense_schur, one thread."""
    table = Table(
        title="Native engine, dense_schur, 1 thread, angle_axis: ns per observation and iteration, "
        "ms to 0.1 % above the best cost; ratios pair by pair"
    )
    for column in (
        "problem",
        "ns/obs: autodiff",
        "analytic",
        "native",
        "ratios",
        "ms to 0.1 %: autodiff",
        "analytic",
        "native",
        "ratios",
    ):
        table.add_column(column, justify="left" if column == "problem" else "right")
    systems = ("ceres_autodiff", "raylign_ceres", "raylign_native")
    results = []
    for path in bal_files():
        if path.name.startswith("street"):
            continue  # its outliers keep least squares from converging: no time to a cost
        rows = run_bal_program(folder, path, "--tight", "--repeats", str(repeats))
        best = min(row["final_cost"] for row in rows)
        for row in rows:
            row["time_to_0.1_percent_s"] = time_to_cost(row, 1.001 * best)
        result: dict = {"problem": path.name, "best_cost": best, "medians": {}, "ratios": {}}
        cells = []
        for field, unit in (
            ("ns_per_observation_and_iteration", 1),
            ("time_to_0.1_percent_s", 1e3),
        ):
            medians = [statistics.median(values(rows, s, "angle_axis", field)) for s in systems]
            ratios = [
                median_ratio(rows, field, (s, "angle_axis"), ("raylign_native", "angle_axis"))
                for s in systems[:2]
            ]
            result["medians"][field] = dict(zip(systems, medians, strict=True))
            result["ratios"][field] = dict(zip(systems[:2], ratios, strict=True))
            cells += [f"{unit * m:.0f}" if unit == 1 else f"{unit * m:.1f}" for m in medians]
            cells.append(" / ".join(f"{r:.1f}" for r in ratios))
        table.add_row(short_name(path), *cells)
        results.append({**result, "rows": rows})
    console.print(table)
    return results


def bench_final_cost(folder: Path, console: Console) -> list[dict]:
    """200 iterations, tolerances 1e-12 / 1e-14 / 1e-14: where both formulations end."""
    table = Table(
        title="Final cost ½Σr², dense_schur, 1 thread, 200 iterations, tolerances 1e-12/1e-14/1e-14"
    )
    for column in ("problem", "start", "Ceres autodiff", "raylign se3", "relative difference"):
        table.add_column(column, justify="left" if column == "problem" else "right")
    results = []
    for path in bal_files():
        rows = run_bal_program(folder, path, "--tight", "--repeats", "1")
        autodiff = next(row for row in rows if row["system"] == "ceres_autodiff")
        ours = next(row for row in rows if (row["system"], row["pose"]) == ("raylign_ceres", "se3"))
        difference = ours["final_cost"] / autodiff["final_cost"] - 1.0
        table.add_row(
            short_name(path),
            f"{autodiff['initial_cost']:.6e}",
            f"{autodiff['final_cost']:.6f}",
            f"{ours['final_cost']:.6f}",
            f"{difference:+.1e}",
        )
        results.append({"problem": path.name, "relative_difference": difference, "rows": rows})
    console.print(table)
    return results


def bench_reading(repeats: int, console: Console) -> list[dict]:
    """Text of the BAL format to arrays, and back."""
    table = Table(title="BAL text (median MB/s of text)")
    for column in ("problem", "MB", "read", "write"):
        table.add_column(column, justify="left" if column == "problem" else "right")
    results = []
    for source in bal_files():
        problem = raylign.io.read_bal(source)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "problem.txt"
            seconds: dict[str, list[float]] = {"read": [], "write": []}
            for _ in range(repeats):
                start = time.perf_counter()
                raylign.io.write_bal(problem, path)
                seconds["write"].append(time.perf_counter() - start)
                start = time.perf_counter()
                raylign.io.read_bal(path)
                seconds["read"].append(time.perf_counter() - start)
            megabytes = path.stat().st_size / 1e6
        speed = {name: megabytes / statistics.median(values) for name, values in seconds.items()}
        table.add_row(
            short_name(source), f"{megabytes:.1f}", f"{speed['read']:.0f}", f"{speed['write']:.0f}"
        )
        results.append({"problem": source.name, "megabytes": megabytes, "megabytes_per_s": speed})
    console.print(table)
    return results


def drop_traces(results: dict) -> None:
    """Forget the cost of every iteration: megabytes, and their summary is kept."""
    for group in results.values():
        for result in group if isinstance(group, list) else []:
            for row in result.get("rows", []):
                row.pop("trace", None)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument(
        "--only", choices=["jacobians", "native", "final_cost", "reading", "import"]
    )
    arguments = parser.parse_args()
    console = Console()
    facts = machine_facts()
    console.print(
        f"{facts['cpu']}, {facts['num_cpus']} CPUs, raylign {facts['raylign']} at {facts['commit']}"
    )
    folder = build_programs()
    benchmarks = {
        "jacobians": lambda: bench_jacobians(folder, arguments.repeats, console),
        "native": lambda: bench_native(folder, arguments.repeats, console),
        "final_cost": lambda: bench_final_cost(folder, console),
        "reading": lambda: bench_reading(arguments.repeats, console),
        "import": measure_import,
    }
    chosen = [arguments.only] if arguments.only else list(benchmarks)
    results = {name: benchmarks[name]() for name in chosen}
    drop_traces(results)
    RESULTS.mkdir(exist_ok=True)
    target = RESULTS / f"bal_{facts['date'][:10]}.json"
    target.write_text(json.dumps({"machine": facts, "results": results}, indent=1) + "\n")
    console.print(f"written: {target.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
