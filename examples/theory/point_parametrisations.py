"""Parametrisations of a point: XYZ, homogeneous and inverse depth, near and far.

    python examples/theory/point_parametrisations.py

Six cameras on a line of length 1 (the baseline) look at landmarks at 10, 1e3 and 1e6 baselines.
Every landmark starts five baselines away, on the true ray. First the cameras are held: what is left
is the triangulation alone. Then cameras and points of a street with far points are free together.
"""

import numpy as np
from matplotlib.figure import Figure

import raylign.synthetic
from common import LINES, Result, print_table, run
from raylign.bundle import (
    Backend,
    BundleConfig,
    BundleOptions,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    PointParametrization,
    adjust,
)
from raylign.scene import BalProblem
from raylign.viz import style

KINDS = (
    PointParametrization.XYZ,
    PointParametrization.HOMOGENEOUS,
    PointParametrization.INVERSE_DEPTH,
)
NUM_CAMERAS = 6
FOCAL = 500.0  # px
PIXEL_NOISE = 0.1  # px
START_DEPTH = 5.0  # baselines
DEPTHS = (10.0, 1e3, 1e6)  # baselines
MAX_ITERATIONS = 60
NEGLIGIBLE = 1e-3  # a cost this close to the best, relative, counts as reached
FLOOR = 1e-6  # lowest excess drawn


def triangulation(depth: float, num_points: int) -> tuple[BalProblem, BalProblem]:
    """(start, truth): parallel cameras along x that look along −z, landmarks `depth` away."""
    rng = np.random.default_rng(5)
    rays = np.column_stack([rng.uniform(-0.4, 0.4, (num_points, 2)), -np.ones(num_points)])
    centres = np.column_stack([np.linspace(-0.5, 0.5, NUM_CAMERAS), np.zeros((NUM_CAMERAS, 2))])
    cameras = np.zeros((NUM_CAMERAS, 9))
    cameras[:, 3:6] = -centres
    cameras[:, 6] = FOCAL
    point_index, camera_index = np.divmod(np.arange(num_points * NUM_CAMERAS), NUM_CAMERAS)
    p_c = depth * rays[point_index] - centres[camera_index]
    observations = -FOCAL * p_c[:, :2] / p_c[:, 2:]
    observations += rng.normal(0.0, PIXEL_NOISE, observations.shape)
    indices = camera_index.astype(np.int32), point_index.astype(np.int32)
    start = BalProblem(cameras, START_DEPTH * rays, *indices, observations)
    return start, BalProblem(cameras, depth * rays, *indices, observations)


def options(kind: PointParametrization, max_num_iterations: int) -> BundleOptions:
    """Tolerances that let the slowest finish, where it can."""
    lm = LmOptions(
        max_num_iterations=max_num_iterations, function_tolerance=1e-12, parameter_tolerance=1e-14
    )
    solver = LinearSolverOptions(type=LinearSolverType.DENSE_SCHUR)
    return BundleOptions(  # one engine and one set of rules for all three
        backend=Backend.CERES, point_parametrization=kind, lm=lm, linear_solver=solver
    )


def compare(
    start: BalProblem, config: BundleConfig, label: str, max_num_iterations: int
) -> list[Result]:
    """One row per parametrisation: cost per iteration, and iterations to the best of the three."""
    results = {
        kind: adjust(start, config=config, options=options(kind, max_num_iterations))
        for kind in KINDS
    }
    best = min(r.summary.final_cost for r in results.values())
    rows = []
    for kind, result in results.items():
        costs = np.minimum.accumulate(result.summary.iterations["cost"])
        reached = np.flatnonzero(costs <= (1.0 + NEGLIGIBLE) * best)
        rows.append(
            {
                "scene": label,
                "kind": kind.name,
                "costs": costs.tolist(),
                "best": best,
                "final_cost": result.summary.final_cost,
                "excess": result.summary.final_cost / best - 1.0,
                "iterations_to_best": int(reached[0]) if len(reached) else None,
            }
        )
    return rows


def behind(problem: BalProblem) -> float:
    """Fraction of the points that ended on the far side of infinity."""
    return float(np.mean(problem.points[:, 2] > 0.0))


def measure(quick: bool) -> Result:
    held = BundleConfig(
        constant_cameras=list(range(NUM_CAMERAS)), constant_intrinsics=list(range(NUM_CAMERAS))
    )
    limit = 25 if quick else MAX_ITERATIONS
    rows: list[Result] = []
    beyond = {}
    for depth in DEPTHS:
        start, _ = triangulation(depth, 50 if quick else 400)
        rows += compare(start, held, f"{depth:g}", limit)
        optimum = adjust(
            start, config=held, options=options(PointParametrization.HOMOGENEOUS, limit)
        )
        beyond[f"{depth:g}"] = behind(optimum.problem)
    street = raylign.synthetic.bal(
        kind="street",
        num_cameras=20,
        num_points=800,
        far_fraction=0.3,
        seed=4,
    ).problem
    rows += compare(street, BundleConfig(), "all free", limit)
    print_table(
        ("landmarks at", "parametrisation", "iterations to best", "final cost", "excess"),
        (
            (r["scene"], r["kind"], r["iterations_to_best"], r["final_cost"], r["excess"])
            for r in rows
        ),
    )
    print("points beyond infinity at the optimum:", beyond)
    return {"rows": rows, "beyond_infinity": beyond}


def draw(result: Result) -> dict[str, Figure]:
    figure = style.new_figure(11.5, 4.1, "Points near and far", "cost above the optimum")
    panels = figure.subplots(1, 4, sharey=True)
    titles = {
        "10": "10 baselines",
        "1000": "1000 baselines",
        "1e+06": "10⁶ baselines",
        "all free": "street, 30 % far, all free",
    }
    for axes, (scene, title) in zip(panels, titles.items(), strict=True):
        for line, kind in zip(LINES, KINDS, strict=False):
            row = next(r for r in result["rows"] if (r["scene"], r["kind"]) == (scene, kind.name))
            excess = np.array(row["costs"]) / row["best"] - 1.0
            name = kind.name.lower().replace("_", " ")
            axes.semilogy(np.maximum(excess, FLOOR), **line, ms=3.5, label=name)
        axes.axhline(NEGLIGIBLE, color=style.MUTED, linewidth=0.8)
        axes.set_title(title)
        axes.set_xlabel("LM iteration")
    panels[0].set_ylabel("cost / best cost − 1")
    panels[0].set_ylim(bottom=0.5 * FLOOR)
    panels[0].annotate(
        "reached",
        (0.99, NEGLIGIBLE),
        (0, 3),
        xycoords=panels[0].get_yaxis_transform(),
        textcoords="offset points",
        ha="right",
        color=style.MUTED,
    )
    style.legend_below(figure, panels[0])
    return {"point-parametrisations": figure}


if __name__ == "__main__":
    run(__doc__, measure, draw)
