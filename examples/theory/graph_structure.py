"""The graph of a bundle adjustment: network, J, H and S of a small scene, and S of two large ones.

    python examples/theory/graph_structure.py

The small figure follows fig. 3 of Triggs et al. 2000 on a scene of our own. The large one compares
a street (a band per lap, joined by loop closures) with an orbit (rings that all see the building),
before and after the cameras are reordered, and counts the blocks of the Cholesky factor: the
fill-in.
"""

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

import raylign.synthetic
from common import Result, print_table, run
from raylign.bundle import linearize
from raylign.scene import BalProblem
from raylign.viz import style

Pattern = npt.NDArray[np.bool_]
CAMERA_DIM = 9
POINT_DIM = 3
NO, CAMERA, POINT, CROSS, FILL = range(5)
COLORS = ListedColormap(["white", style.AFTER, style.ACCENT, style.BEFORE, "#d4b7ae"])


def small_scene() -> BalProblem:
    """Few cameras and points, each point in a few views, ordered by its first camera."""
    return raylign.synthetic.bal(
        kind="orbit", num_cameras=9, num_points=36, mean_track_length=2.5, seed=12
    ).problem


def visibility(problem: BalProblem) -> Pattern:
    """(C, P) which camera sees which point: the network graph as a matrix."""
    seen = np.zeros((problem.num_cameras, problem.num_points), bool)
    seen[problem.camera_index, problem.point_index] = True
    return seen


def shared(problem: BalProblem) -> Pattern:
    """(C, C) which cameras have a point in common: the pattern of S, without forming it."""
    count = np.zeros((problem.num_cameras, problem.num_cameras), np.float32)
    seen = visibility(problem)
    for first in range(0, problem.num_points, 4096):
        part = seen[:, first : first + 4096].astype(np.float32)
        count += part @ part.T
    return count > 0


def factor_pattern(pattern: Pattern, order: npt.NDArray[np.int64]) -> Pattern:
    """Blocks of the Cholesky factor: eliminating a node joins its remaining neighbours."""
    filled = pattern[np.ix_(order, order)].copy()
    for k in range(len(order)):
        later = k + 1 + np.flatnonzero(filled[k + 1 :, k])
        filled[np.ix_(later, later)] = True
    return np.tril(filled)


def minimum_degree(pattern: Pattern) -> npt.NDArray[np.int64]:
    """Greedy order: next the node with the fewest neighbours left (Tinney & Walker 1967)."""
    graph = pattern.copy()
    np.fill_diagonal(graph, False)
    left = np.ones(len(graph), bool)
    order = []
    for _ in range(len(graph)):
        degree = np.where(left, graph.sum(axis=1), len(graph) + 1)
        node = int(np.argmin(degree))
        order.append(node)
        neighbours = np.flatnonzero(graph[node])
        graph[np.ix_(neighbours, neighbours)] = True
        graph[neighbours, neighbours] = False
        graph[node, :] = graph[:, node] = False
        left[node] = False
    return np.array(order)


def jacobian_pattern(problem: BalProblem) -> Pattern:
    """Non-zeros of J as `linearize` returns it (a free gauge; exact zeros stay in the pattern)."""
    linear = linearize(problem)
    rows = np.repeat(np.arange(len(linear.residuals)), np.diff(linear.row_starts))
    pattern = np.zeros((len(linear.residuals), linear.num_columns), bool)
    pattern[rows, linear.columns] = True
    return pattern


def schur_pattern(problem: BalProblem) -> Pattern:
    """Non-zero 9x9 blocks of S = H_pp − H_pl H_ll⁻¹ H_lp, from the numbers."""
    linear = linearize(problem)
    J = np.zeros((len(linear.residuals), linear.num_columns))
    rows = np.repeat(np.arange(len(linear.residuals)), np.diff(linear.row_starts))
    J[rows, linear.columns] = linear.values
    H = J.T @ J
    split = CAMERA_DIM * problem.num_cameras
    # tracks of two views fix a point; no damping is needed here
    S = H[:split, :split] - H[:split, split:] @ np.linalg.solve(
        H[split:, split:], H[split:, :split]
    )
    C = problem.num_cameras
    blocks = np.abs(S.reshape(C, CAMERA_DIM, C, CAMERA_DIM)).max(axis=(1, 3))
    scale = np.sqrt(np.outer(np.diag(blocks), np.diag(blocks)))
    return blocks > 1e-9 * scale


def measure(quick: bool) -> Result:
    small = small_scene()
    rows = []
    patterns = {}
    for kind, cameras in (("street", 60 if quick else 240), ("orbit", 30 if quick else 240)):
        problem = raylign.synthetic.bal(
            kind=kind, num_cameras=cameras, num_points=20 * cameras, seed=6
        ).problem
        pattern = shared(problem)
        orders = {"given": np.arange(cameras), "minimum degree": minimum_degree(pattern)}
        for name, order in orders.items():
            factor = factor_pattern(pattern, order)
            lower = int(np.tril(pattern).sum())
            rows.append(
                {
                    "kind": kind,
                    "order": name,
                    "cameras": cameras,
                    "blocks_S": lower,
                    "blocks_L": int(factor.sum()),
                    "full": cameras * (cameras + 1) // 2,
                    "density_S": float(pattern.mean()),
                }
            )
            patterns[f"{kind}, {name}"] = {
                "S": pattern[np.ix_(order, order)].tolist(),
                "L": factor.tolist(),
            }
    print_table(
        ("scene", "order", "cameras", "blocks of S", "blocks of L", "if full"),
        (
            (r["kind"], r["order"], r["cameras"], r["blocks_S"], r["blocks_L"], r["full"])
            for r in rows
        ),
    )
    J = jacobian_pattern(small)
    H = J.T.astype(int) @ J.astype(int) > 0
    small_numbers = {
        "J_shape": J.shape,
        "J_density": float(J.mean()),
        "H_density": float(H.mean()),
        "S_equals_shared": bool(np.array_equal(schur_pattern(small), shared(small))),
    }
    print(f"small scene: J {J.shape}, {J.mean():.1%} filled; H {H.mean():.1%} filled")
    return {"rows": rows, "patterns": patterns, "small": small_numbers}


def draw_network(axes: Axes, problem: BalProblem) -> None:
    """Cameras and points from above; one edge per observation."""
    centres = problem.camera_centers()[:, :2]
    points = problem.points[:, :2]
    for i, j in zip(problem.camera_index, problem.point_index, strict=True):
        axes.plot(*np.transpose([centres[i], points[j]]), color="#9ca3af", linewidth=0.5, zorder=1)
    axes.scatter(*points.T, s=14, color=style.ACCENT, zorder=2, label="point")
    axes.scatter(*centres.T, s=80, marker="s", color=style.AFTER, zorder=3)
    for k, centre in enumerate(centres):
        axes.annotate(str(k), centre, ha="center", va="center", color="white", fontsize=7, zorder=4)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.set_title("Network graph, from above")


def draw_blocks(axes: Axes, kinds: npt.NDArray[np.int64], split: int | None, title: str) -> None:
    axes.imshow(kinds, cmap=COLORS, vmin=0, vmax=4, interpolation="none", aspect="auto")
    if split is not None:
        axes.axvline(split - 0.5, color=style.MUTED, linewidth=0.8)
    axes.grid(visible=False)
    axes.set_title(title)


def draw_small(problem: BalProblem) -> Figure:
    split = CAMERA_DIM * problem.num_cameras
    J = jacobian_pattern(problem)
    kind_of_column = np.where(np.arange(J.shape[1]) < split, CAMERA, POINT)
    H = J.T.astype(int) @ J.astype(int) > 0
    kind_of_block = np.where(
        kind_of_column[:, None] == kind_of_column, kind_of_column[None, :], CROSS
    )
    S = shared(problem)
    S_kinds = np.where(S & np.eye(len(S), dtype=bool), CAMERA, np.where(S, FILL, NO))
    figure = style.new_figure(13.0, 3.9, "One scene, four pictures", f"{style.size_text(problem)}")
    network, jacobian, hessian, reduced = figure.subplots(1, 4, width_ratios=[1.15, 0.8, 1, 1])
    draw_network(network, problem)
    draw_blocks(jacobian, np.where(J, kind_of_column, NO), split, f"J, {J.mean():.0%} filled")
    jacobian.set_xlabel("9 per camera | 3 per point")
    jacobian.set_ylabel("2 per observation")
    draw_blocks(hessian, np.where(H, kind_of_block, NO), split, f"H = JᵀJ, {H.mean():.0%} filled")
    hessian.axhline(split - 0.5, color=style.MUTED, linewidth=0.8)
    hessian.set_xlabel("cameras | points")
    draw_blocks(reduced, S_kinds, None, f"S, {S.mean():.0%} filled")
    reduced.set_xlabel("camera")
    reduced.set_ylabel("camera")
    for color, name in (
        (style.AFTER, "camera block"),
        (style.ACCENT, "point block"),
        (style.BEFORE, "camera-point block"),
        ("#d4b7ae", "two cameras share a point"),
    ):
        hessian.plot([], [], "s", color=color, label=name)
    style.legend_below(figure, hessian)
    return figure


def draw_large(result: Result) -> Figure:
    rows = result["rows"]
    figure = style.new_figure(
        12.0, 6.9, "Fill-in", "reduced camera matrix S and its Cholesky factor L"
    )
    panels = figure.subplots(2, 4)
    for row, column in ((r, c) for r in range(2) for c in range(2)):
        facts = rows[2 * row + column]
        patterns = result["patterns"][f"{facts['kind']}, {facts['order']}"]
        S, L = np.array(patterns["S"]), np.array(patterns["L"])
        fill = L & ~np.tril(S)
        kinds = np.where(fill, CROSS, np.where(L, CAMERA, NO))
        draw_blocks(panels[row, 2 * column], np.where(S, CAMERA, NO), None, "")
        draw_blocks(panels[row, 2 * column + 1], kinds, None, "")
        panels[row, 2 * column].set_title(f"{facts['kind']}, {facts['order']}: S")
        panels[row, 2 * column + 1].set_title(
            f"L: {style.count(facts['blocks_L'])} blocks, {fill.sum() / max(1, L.sum()):.0%} new"
        )
    for axes in panels.flat:
        axes.set_aspect("equal")
        axes.set_xticks([0, 80, 160, 239])
        axes.set_yticks([0, 80, 160, 239])
    for color, name in ((style.AFTER, "block of S"), (style.BEFORE, "fill-in")):
        panels[0, 0].plot([], [], "s", color=color, label=name)
    style.legend_below(figure, panels[0, 0])
    return figure


def draw(result: Result) -> dict[str, Figure]:
    return {"graph-structure": draw_small(small_scene()), "fill-in": draw_large(result)}


if __name__ == "__main__":
    run(__doc__, measure, draw)
