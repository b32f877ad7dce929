"""Parametrisations of a rotation near their singularities.

    python examples/theory/pose_parametrisations.py

First the map from the parameters to the rotation: its smallest singular value, 0 where a direction
of rotation cannot be reached. Then Gauss-Newton on the pose of one camera (plain NumPy, no
damping), with the sought rotation nearer and nearer to a singularity: how many iterations each
parametrisation needs.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from common import LINES, Result, print_table, run
from raylign.geometry import (
    quaternion_exp,
    quaternion_from_matrix,
    quaternion_to_matrix,
    so3_exp,
    so3_hat,
    so3_left_jacobian,
    so3_log,
)
from raylign.viz import style

Array = npt.NDArray[np.float64]
FOCAL = 500.0  # px
NUM_POINTS = 30
START_ERROR_DEG = 10.0
MAX_ITERATIONS = 50
CONVERGED_RAD = 1e-7
E_X, E_Y, E_Z = np.eye(3)


def euler_to_matrix(angles: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll), angles = (roll, pitch, yaw) in rad."""
    roll, pitch, yaw = angles
    return so3_exp(yaw * E_Z) @ so3_exp(pitch * E_Y) @ so3_exp(roll * E_X)


def euler_from_matrix(R: Array) -> Array:
    """Roll, pitch in [-90°, 90°] and yaw; at gimbal lock roll and yaw are not unique."""
    pitch = np.arcsin(np.clip(-R[2, 0], -1.0, 1.0))
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def euler_map(angles: Array) -> Array:
    """dφ/dangles (3, 3) with R <- exp(φ) R: the three axes of rotation, in the outer frame."""
    _, pitch, yaw = angles
    outer = so3_exp(yaw * E_Z)
    return np.column_stack([outer @ so3_exp(pitch * E_Y) @ E_X, outer @ E_Y, E_Z])


def quaternion_map(q: Array) -> Array:
    """dφ/dq (3, 4) at a unit quaternion xyzw; q itself is its null space."""
    x, y, z, w = q
    return 2.0 * np.array([[w, -z, y, -x], [z, w, -x, -y], [-y, x, w, -z]])


def near_angle_axis(R: Array, angle: float) -> Array:
    """The rotation vector of R nearest to `angle` in length: one of ω, ω + 2π along its axis."""
    omega = so3_log(R)
    short = float(np.linalg.norm(omega))
    axis = omega / short
    candidates = [short * axis, (short - 2.0 * np.pi) * axis]
    return min(candidates, key=lambda v: abs(float(np.linalg.norm(v)) - angle))


@dataclass(frozen=True)
class Parametrisation:
    """Numbers for a rotation: to the matrix, its map to φ, and how a step is added."""

    name: str
    to_matrix: Callable[[Array], Array]
    rotation_map: Callable[[Array], Array]
    add: Callable[[Array, Array], Array]


def _normalised_sum(q: Array, step: Array) -> Array:
    return (q + step) / np.linalg.norm(q + step)


def _left_product(R_flat: Array, phi: Array) -> Array:
    return (so3_exp(phi) @ R_flat.reshape(3, 3)).ravel()


EULER = Parametrisation("Euler angles", euler_to_matrix, euler_map, np.add)
ANGLE_AXIS = Parametrisation("angle-axis", so3_exp, so3_left_jacobian, np.add)
QUATERNION = Parametrisation(
    "quaternion, normalised", quaternion_to_matrix, quaternion_map, _normalised_sum
)
LOCAL = Parametrisation(
    "local: exp(φ) R", lambda p: p.reshape(3, 3), lambda p: np.eye(3), _left_product
)


def smallest_singular_value(jacobian: Array) -> float:
    """Of the directions of rotation (three), whatever the number of parameters."""
    return float(np.linalg.svd(jacobian, compute_uv=False)[2])


def measure_maps(num_samples: int) -> Result:
    """Smallest singular values along the pitch (Euler) and along the angle (the others)."""
    pitch = np.linspace(0.0, 90.0, num_samples)
    angle = np.linspace(0.0, 360.0, 2 * num_samples)
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    vectors = np.deg2rad(angle)[:, None] * axis
    return {
        "pitch_deg": pitch.tolist(),
        "angle_deg": angle.tolist(),
        "euler": [
            smallest_singular_value(euler_map(np.array([0.3, p, -0.8]))) for p in np.deg2rad(pitch)
        ],
        "angle_axis": [smallest_singular_value(so3_left_jacobian(v)) for v in vectors],
        # half the length of q is the natural unit: dφ = 2 dq
        "quaternion": [
            0.5 * smallest_singular_value(quaternion_map(quaternion_exp(v))) for v in vectors
        ],
        "quaternion_null": max(
            float(np.linalg.norm(quaternion_map(q) @ q)) for q in quaternion_exp(vectors)
        ),
    }


def refine(
    kind: Parametrisation, start: Array, t_start: Array, R_true: Array, points: Array
) -> int:
    """Gauss-Newton on (rotation, t_cw): iterations to the truth, MAX_ITERATIONS if never."""
    t_true = np.array([0.0, 0.0, 6.0])
    observed = project(points @ R_true.T + t_true)[0]
    parameters, t = start.copy(), t_start.copy()
    for iteration in range(MAX_ITERATIONS):
        R = kind.to_matrix(parameters)
        if np.linalg.norm(R - R_true) < CONVERGED_RAD:
            return iteration
        rotated = points @ R.T
        predicted, J_p = project(rotated + t)
        J_rotation = -J_p @ so3_hat(rotated) @ kind.rotation_map(parameters)
        J = np.concatenate([J_rotation, J_p], axis=2).reshape(2 * len(points), -1)
        # minimum-norm step: the null direction of a quaternion is left alone
        step = np.linalg.lstsq(J, (observed - predicted).ravel(), rcond=1e-12)[0]
        parameters = kind.add(parameters, step[:-3])
        t = t + step[-3:]
        if not (np.all(np.isfinite(parameters)) and np.linalg.norm(step) < 1e9):
            break
    return MAX_ITERATIONS


def project(p_c: Array) -> tuple[Array, Array]:
    """Pinhole: pixels (N, 2) and ∂/∂p_c (N, 2, 3)."""
    x, y, z = p_c.T
    pixels = FOCAL * np.column_stack([x / z, y / z])
    J = np.zeros((len(p_c), 2, 3))
    J[:, 0, 0] = J[:, 1, 1] = FOCAL / z
    J[:, 0, 2], J[:, 1, 2] = -pixels[:, 0] / z, -pixels[:, 1] / z
    return pixels, J


def unit(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def trial(rng: np.random.Generator, distance: float) -> dict[str, int]:
    """One camera, `distance` (rad) from the singularity of Euler angles and of the angle-axis."""
    points = rng.uniform(-1.0, 1.0, (NUM_POINTS, 3))
    error = so3_exp(np.deg2rad(START_ERROR_DEG) * unit(rng))
    t_start = np.array([0.0, 0.0, 6.0]) + rng.normal(0.0, 0.2, 3)
    euler = np.array([rng.uniform(-3, 3), np.pi / 2 - distance, rng.uniform(-3, 3)])
    R_euler = euler_to_matrix(euler)
    angle = 2.0 * np.pi - distance
    omega = angle * unit(rng)
    R_angle = so3_exp(omega)
    R_start = error @ R_angle
    starts = (
        (EULER, euler_from_matrix(error @ R_euler), R_euler),
        (ANGLE_AXIS, near_angle_axis(R_start, angle), R_angle),
        (QUATERNION, quaternion_from_matrix(R_start), R_angle),
        (LOCAL, R_start.ravel(), R_angle),
    )
    return {kind.name: refine(kind, start, t_start, R, points) for kind, start, R in starts}


def measure_refinement(distances_deg: list[float], num_trials: int) -> list[Result]:
    """Median iterations and failures per parametrisation and distance."""
    rows = []
    for index, distance in enumerate(distances_deg):
        rng = np.random.default_rng((3, index))
        counts = [trial(rng, np.deg2rad(distance)) for _ in range(num_trials)]
        for kind in (EULER, ANGLE_AXIS, QUATERNION, LOCAL):
            own = np.array([count[kind.name] for count in counts])
            rows.append(
                {
                    "kind": kind.name,
                    "distance_deg": distance,
                    "median": float(np.median(own)),
                    "worst_decile": float(np.quantile(own, 0.9)),
                    "failed": float(np.mean(own >= MAX_ITERATIONS)),
                }
            )
    return rows


def measure(quick: bool) -> Result:
    distances = [60.0, 0.01] if quick else [60.0, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01]
    maps = measure_maps(10 if quick else 181)
    refinement = measure_refinement(distances, 20 if quick else 200)
    print_table(
        ("parametrisation", "deg to singularity", "iterations", "90 %", "failed"),
        (
            (r["kind"], r["distance_deg"], r["median"], r["worst_decile"], r["failed"])
            for r in refinement
        ),
    )
    return {"maps": maps, "refinement": refinement}


def draw_iterations(iterations: Axes, rows: list[Result]) -> None:
    """Slowest decile as lines; the angle-axis' failures as bars on an axis of their own."""
    for kind, line in zip((EULER, ANGLE_AXIS, QUATERNION, LOCAL), LINES, strict=True):
        own = [r for r in rows if r["kind"] == kind.name]
        x = [r["distance_deg"] for r in own]
        size = 8.0 if kind is QUATERNION else 4.5  # it lies under the local one
        iterations.plot(x, [r["worst_decile"] for r in own], **line, ms=size, label=kind.name)
    iterations.set_xscale("log")
    iterations.invert_xaxis()
    iterations.axhline(MAX_ITERATIONS, color=style.MUTED, linewidth=0.8)
    failures = iterations.twinx()
    own = [r for r in rows if r["kind"] == ANGLE_AXIS.name]
    failures.bar(
        [r["distance_deg"] for r in own],
        [100 * r["failed"] for r in own],
        width=[0.35 * r["distance_deg"] for r in own],
        color=LINES[1]["color"],
        alpha=0.25,
    )
    failures.set_zorder(iterations.get_zorder() - 1)
    iterations.patch.set_visible(False)
    failures.set_ylim(0, 2 * MAX_ITERATIONS + 6)
    failures.set_ylabel("starts that never converge (%)")
    failures.grid(visible=False)
    iterations.set_ylim(0, MAX_ITERATIONS + 3)
    iterations.set_xlabel("distance from the singularity (°)")
    iterations.set_ylabel("Gauss-Newton iterations, 90 % of starts")
    iterations.set_title("Iterations to the pose")
    iterations.set_xticks([60, 10, 1, 0.1, 0.01], ["60", "10", "1", "0.1", "0.01"])
    iterations.text(
        0.99, 0.915, "50 = not converged", transform=iterations.transAxes, ha="right", va="top",
        color=style.MUTED,
    )  # fmt: skip
    bars = "angle-axis: never converge (right axis)"
    iterations.plot([], [], "s", ms=8.0, color=LINES[1]["color"], alpha=0.25, label=bars)


def draw(result: Result) -> dict[str, Figure]:
    figure = style.new_figure(11.0, 4.1, "Rotations near their singularities")
    euler, angle, iterations = figure.subplots(1, 3)
    maps = result["maps"]
    local = {**LINES[3], "marker": ""}
    euler.plot(maps["pitch_deg"], maps["euler"], color=LINES[0]["color"], label="Euler angles")
    euler.axhline(1.0, **local, label="local: exp(φ) R")
    euler.set_xlabel("pitch (°)")
    euler.set_xticks([0, 30, 60, 90])
    euler.set_title("Euler: gimbal lock at 90°")
    angle.plot(maps["angle_deg"], maps["angle_axis"], color=LINES[1]["color"], label="angle-axis")
    angle.plot(
        maps["angle_deg"],
        maps["quaternion"],
        color=LINES[2]["color"],
        linestyle="--",
        linewidth=3.0,
        label="quaternion (÷ 2)",
    )
    angle.axhline(1.0, **local, label="local: exp(φ) R")
    angle.set_xlabel("angle of rotation (°)")
    angle.set_xticks([0, 90, 180, 270, 360])
    angle.set_title("Angle-axis: blind at 360°")
    for axes in (euler, angle):
        axes.set_ylim(0.0, 1.12)
        axes.set_ylabel("smallest singular value of the map")
        axes.legend(loc="lower left")
    draw_iterations(iterations, result["refinement"])
    style.legend_below(figure, iterations)
    return {"pose-parametrisations": figure}


if __name__ == "__main__":
    run(__doc__, measure, draw)
