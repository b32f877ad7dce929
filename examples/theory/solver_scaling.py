"""Why bundle adjustment is not slow: time per iteration of four linear solvers.

    python examples/theory/solver_scaling.py

Two sweeps: points at a fixed number of cameras, where the dense normal equations part from the
Schur complement; and cameras of a street loop, where a dense Schur complement parts from a sparse
or iterative one.
"""

import time

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import raylign.synthetic
from common import LINES, Result, print_table, run
from raylign.bundle import (
    Backend,
    BundleOptions,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    adjust,
)
from raylign.errors import OptionsError
from raylign.scene import BalProblem
from raylign.viz import style

SOLVERS = (
    LinearSolverType.DENSE_NORMAL_CHOLESKY,
    LinearSolverType.DENSE_SCHUR,
    LinearSolverType.SPARSE_SCHUR,
    LinearSolverType.ITERATIVE_SCHUR,
)
NAMES = {
    "DENSE_NORMAL_CHOLESKY": "dense normal equations",
    "DENSE_SCHUR": "dense Schur",
    "SPARSE_SCHUR": "sparse Schur",
    "ITERATIVE_SCHUR": "iterative Schur (PCG)",
}
NUM_CAMERAS = 8
POINTS_PER_CAMERA = 40
NUM_ITERATIONS = 3
MIN_TIME_S = 0.4  # repeat a small solve until this much time is spent
MAX_DENSE_BYTES = 8e9  # the limit of DENSE_NORMAL_CHOLESKY


def bundle_options(solver: LinearSolverType) -> BundleOptions:
    """A fixed number of iterations: tolerances that never stop."""
    lm = LmOptions(
        max_num_iterations=NUM_ITERATIONS,
        function_tolerance=0.0,
        gradient_tolerance=0.0,
        parameter_tolerance=0.0,
    )
    return BundleOptions(  # the engine that has all of them
        backend=Backend.CERES, lm=lm, linear_solver=LinearSolverOptions(type=solver)
    )


def time_solver(problem: BalProblem, solver: LinearSolverType, min_time_s: float) -> Result:
    """Median time of an iteration over repeated solves, and where they end.

    The iteration callback reads the clock of this process, which stands still while others run: on
    an idle machine it agrees with the wall clock (the solver has one thread), on a busy one it is
    the one to trust.
    """
    times: list[float] = []
    start = time.perf_counter()
    while not times or time.perf_counter() - start < min_time_s:
        stamps: list[float] = []
        summary = adjust(
            problem,
            options=bundle_options(solver),
            callback=lambda row, into=stamps: into.append(time.process_time()),
        ).summary
        times.extend(np.diff(stamps).tolist())
    return {
        "solver": solver.name,
        "cameras": problem.num_cameras,
        "points": problem.num_points,
        "observations": problem.num_observations,
        "seconds": float(np.median(times)),
        "flops": count_flops(problem, solver),
        "final_cost": summary.final_cost,
    }


def count_flops(problem: BalProblem, solver: LinearSolverType) -> float | None:
    """Leading terms of forming and factoring a dense system; None where the pattern rules."""
    cameras, points = 9.0 * problem.num_cameras, 3.0 * problem.num_points
    if solver == LinearSolverType.DENSE_NORMAL_CHOLESKY:
        n = cameras + points
        return 2.0 * problem.num_observations * n**2 + n**3 / 3.0
    if solver == LinearSolverType.DENSE_SCHUR:
        track = np.bincount(problem.point_index, minlength=problem.num_points)
        # each pair of views of a point: one 9x3 by 3x9 product
        return float(486.0 * np.sum(track * (track + 1) / 2) + cameras**3 / 3.0)
    return None


def refused_size() -> int:
    """Smallest number of points (to 5 %) whose dense J and JᵀJ need more than 8 GB."""
    points = 4000
    problem = orbit(points)
    while dense_bytes(problem) <= MAX_DENSE_BYTES:
        points = int(1.05 * points)
        problem = orbit(points)
    try:
        adjust(problem, options=bundle_options(LinearSolverType.DENSE_NORMAL_CHOLESKY))
    except OptionsError as error:
        print(f"{points} points: {error}")
    return points


def dense_bytes(problem: BalProblem) -> float:
    """Memory of J (2N x n) and JᵀJ (n x n) as dense matrices of doubles."""
    columns = 9.0 * problem.num_cameras + 3.0 * problem.num_points
    return 8.0 * columns * (2.0 * problem.num_observations + columns)


def orbit(num_points: int) -> BalProblem:
    """A few cameras around a building."""
    return raylign.synthetic.bal(
        kind="orbit", num_cameras=NUM_CAMERAS, num_points=num_points, seed=2
    ).problem


def street(num_cameras: int) -> BalProblem:
    """Two laps through a city: each camera shares points with few others."""
    return raylign.synthetic.bal(
        kind="street", num_cameras=num_cameras, num_points=POINTS_PER_CAMERA * num_cameras, seed=2
    ).problem


def fitted_exponent(rows: list[Result], size: str, value: str = "seconds") -> float:
    """Slope of log time over log size, over the last four sizes."""
    last = [row for row in rows if row[value] is not None][-4:]
    if len(last) < 2:
        return float("nan")
    slope = np.polyfit(np.log([r[size] for r in last]), np.log([r[value] for r in last]), 1)[0]
    return float(slope)


def sweep(
    problems: list[BalProblem], size: str, limits: dict[str, int], min_time_s: float
) -> list[Result]:
    """Time every solver on every problem up to the solver's own limit."""
    rows = []
    for problem in problems:
        for solver in SOLVERS:
            if getattr(problem, f"num_{size}") <= limits.get(solver.name, 10**9):
                rows.append(time_solver(problem, solver, min_time_s))
    print_table(
        (size, "observations", "solver", "ms / iteration", "flops", "final cost"),
        (
            (
                r[size],
                r["observations"],
                r["solver"],
                1e3 * r["seconds"],
                r["flops"],
                r["final_cost"],
            )
            for r in rows
        ),
    )
    for solver in SOLVERS:
        own = [r for r in rows if r["solver"] == solver.name]
        if len(own) > 1:
            print(f"{solver.name}: time ~ {size}^{fitted_exponent(own, size):.2f} (last sizes)")
    print()
    return rows


def measure(quick: bool) -> Result:
    points = [32, 64, 128] if quick else [32, 100, 178, 316, 562, 1000, 3160, 10000, 31600, 100000]
    cameras = [16, 32] if quick else [25, 50, 100, 200, 400, 800, 1600, 3200]
    min_time_s = 0.0 if quick else MIN_TIME_S
    by_points = sweep(
        [orbit(n) for n in points],
        "points",
        {"DENSE_NORMAL_CHOLESKY": 128 if quick else 1000},
        min_time_s,
    )
    by_cameras = sweep(
        [street(n) for n in cameras],
        "cameras",
        {"DENSE_NORMAL_CHOLESKY": 0, "DENSE_SCHUR": 800, "SPARSE_SCHUR": 1600},
        min_time_s,
    )
    return {"by_points": by_points, "by_cameras": by_cameras, "refused_points": refused_size()}


def plot_times(axes: Axes, rows: list[Result], size: str) -> None:
    for solver, line in zip(SOLVERS, LINES, strict=True):
        own = [r for r in rows if r["solver"] == solver.name]
        if not own:
            continue
        label = f"{NAMES[solver.name]}: slope {fitted_exponent(own, size):.1f}"
        axes.loglog([r[size] for r in own], [r["seconds"] for r in own], **line, ms=5, label=label)
    axes.set_ylabel("CPU time per LM iteration (s)")
    axes.legend(loc="upper left")


def draw(result: Result) -> dict[str, Figure]:
    by_points = style.new_figure(
        7.6, 4.6, "Time against points", f"{NUM_CAMERAS} cameras around a building"
    )
    axes = by_points.subplots()
    plot_times(axes, result["by_points"], "points")
    axes.set_xlabel("points")
    refused = result["refused_points"]
    axes.axvline(refused, color=style.MUTED, linewidth=1.0, linestyle=":")
    axes.annotate(
        "dense normal equations\nrefused: more than 8 GB",
        (refused, axes.get_ylim()[1]),
        xytext=(6, -4),
        textcoords="offset points",
        va="top",
        color=style.MUTED,
    )
    by_cameras = style.new_figure(
        7.6, 4.6, "Time against cameras", f"street loop, {POINTS_PER_CAMERA} points per camera"
    )
    axes = by_cameras.subplots()
    plot_times(axes, result["by_cameras"], "cameras")
    axes.set_xlabel("cameras")
    return {"solver-scaling-points": by_points, "solver-scaling-cameras": by_cameras}


if __name__ == "__main__":
    run(__doc__, measure, draw)
