"""Single stages: Jacobians through Ceres, text in and out, what two threads could gain."""

import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

import raylign
from harness.problems import ROOT, SHARED, find_file


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


def bench_reference_loops(folder: Path, console: Console) -> dict:
    """What two threads can gain on this machine at this moment, at most."""
    output = subprocess.run(
        [folder / "reference_loops"], check=True, capture_output=True, text=True
    )
    row: dict = json.loads(output.stdout)
    console.print(
        "two threads: memory {triad_gb_per_s[0]} -> {triad_gb_per_s[1]} GB/s, arithmetic "
        "{multiply_add_gflop_per_s[0]} -> {multiply_add_gflop_per_s[1]} GFLOP/s".format(**row)
    )
    return row


def bench_stages(folder: Path, console: Console) -> list[dict]:
    """Each stage of a native iteration, with the bytes and flops it cannot do without."""
    problems = {name: find_file(name) for name in ("trafalgar-21", "orbit-250-65000")}
    results = []
    for name, path in problems.items():
        for threads in (1, 2) if path is not None else ():
            output = subprocess.run(
                [folder / "native_stages", path, "--threads", str(threads), "--repeats", "7"],
                check=True,
                capture_output=True,
                text=True,
            )
            facts, *rows = (json.loads(line) for line in output.stdout.splitlines())
            results.append({**facts, "problem": name, "threads": threads, "stages": rows})
            console.print(f"stages of {name}, {threads} threads: done")
    return results
