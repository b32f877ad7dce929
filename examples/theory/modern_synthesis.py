"""Two themes of Triggs et al. 2000: robust losses and gauge.

    python examples/theory/modern_synthesis.py

Robust losses: ρ and the weight ρ′ of each, and the error of the cameras when observations are
outliers. Gauge: three ways to remove the seven freedoms of a reconstruction reach the same cost;
what they call the uncertainty of a camera is not the same.
"""

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

import raylign.synthetic
from common import LINES, Result, print_table, run
from raylign.bundle import (
    BundleConfig,
    BundleOptions,
    Gauge,
    LmOptions,
    adjust,
    linearize,
)
from raylign.evaluate import camera_center_errors
from raylign.robust import Loss
from raylign.scene import BalProblem
from raylign.synthetic import SyntheticBal
from raylign.viz import style

LOSSES = ("trivial", "huber:1", "cauchy:1", "tukey:3", "student_t:1:5")
OUTLIERS = (0.0, 0.02, 0.05, 0.1, 0.2)
GAUGES = (Gauge.FREE, Gauge.FIRST_CAMERA, Gauge.TWO_CAMERAS)
STYLES = (*LINES, {"color": "#7b5ea7", "linestyle": "-.", "marker": "v"})
Array = npt.NDArray[np.float64]


def sample_loss(text: str, r: Array) -> Result:
    rho, weight, _ = Loss.parse(text).evaluate(r * r)
    return {"loss": text, "rho": rho.tolist(), "weight": weight.tolist()}


def rms_error(problem: BalProblem, truth: BalProblem) -> float:
    """RMS distance of the camera centres to the truth after the best similarity, m."""
    return float(np.sqrt(np.mean(camera_center_errors(problem, truth) ** 2)))


def outlier_scene(fraction: float, quick: bool) -> SyntheticBal:
    return raylign.synthetic.bal(
        kind="orbit",
        num_cameras=12 if quick else 30,
        num_points=300 if quick else 2000,
        outlier_fraction=fraction,
        seed=8,
    )


def measure_outliers(quick: bool) -> list[Result]:
    rows = []
    for fraction in (0.0, 0.1) if quick else OUTLIERS:
        scene = outlier_scene(fraction, quick)
        for loss in LOSSES:
            options = BundleOptions(loss=Loss.parse(loss), lm=LmOptions(max_num_iterations=60))
            problem = adjust(scene.problem, options=options).problem
            rows.append(
                {"loss": loss, "outliers": fraction, "error_m": rms_error(problem, scene.truth)}
            )
    return rows


def gauge_scene(quick: bool) -> SyntheticBal:
    cameras = 6 if quick else 16
    return raylign.synthetic.bal(kind="orbit", num_cameras=cameras, num_points=10 * cameras, seed=3)


def held_intrinsics(problem: BalProblem) -> BundleConfig:
    """Free poses and points only: then the null space of H is the seven freedoms and no more."""
    return BundleConfig(constant_intrinsics=list(range(problem.num_cameras)))


def dense_jacobian(problem: BalProblem) -> Array:
    """J with respect to poses [υ; ω] and points, the gauge free."""
    linear = linearize(problem, config=held_intrinsics(problem))
    J = np.zeros((len(linear.residuals), linear.num_columns))
    rows = np.repeat(np.arange(len(linear.residuals)), np.diff(linear.row_starts))
    J[rows, linear.columns] = linear.values
    return J


def covariance(J: Array, gauge: Gauge) -> Array:
    """(JᵀJ)⁺ for 1 px of noise. A free gauge gives the inner choice of Triggs et al. 2000, §9."""
    free = np.ones(J.shape[1], bool)
    if gauge == Gauge.FIRST_CAMERA:
        free[:6] = False  # scale is left to the pseudo-inverse
    sigma = np.zeros((J.shape[1], J.shape[1]))
    sigma[np.ix_(free, free)] = np.linalg.pinv(
        J[:, free].T @ J[:, free], rcond=1e-11, hermitian=True
    )
    return sigma


def centre_sigmas(sigma: Array, num_cameras: int) -> Array:
    """Standard deviation of each camera centre, m.

    With T_cw <- exp([υ; ω]) T_cw the centre moves by −Rᵀ υ, so the block of υ has its trace.
    """
    variances = np.diag(sigma)[: 6 * num_cameras].reshape(-1, 6)
    return np.sqrt(variances[:, :3].sum(axis=1))


def null_space_size(J: Array) -> int:
    """Dimension of the null space of J: 3 of rotation, 3 of translation, 1 of scale."""
    singular = np.linalg.svd(J / np.linalg.norm(J, axis=0), compute_uv=False)
    return int(np.sum(singular < 1e-8 * singular[0]))


def measure_gauge(quick: bool) -> Result:
    start = gauge_scene(quick).problem
    lm = LmOptions(max_num_iterations=50, function_tolerance=1e-14, parameter_tolerance=1e-14)
    rows = []
    for gauge in GAUGES:
        result = adjust(start, config=BundleConfig(gauge=gauge), options=BundleOptions(lm=lm))
        rows.append(
            {
                "gauge": gauge.name,
                "unknowns": result.summary.num_effective_parameters,
                "costs": result.summary.iterations["cost"].tolist(),
                "final_cost": result.summary.final_cost,
            }
        )
    J = dense_jacobian(result.problem)
    free, first = (covariance(J, gauge) for gauge in (Gauge.FREE, Gauge.FIRST_CAMERA))
    num_cameras = result.problem.num_cameras
    return {
        "rows": rows,
        "null_space": null_space_size(J),
        "sigma_free": centre_sigmas(free, num_cameras).tolist(),
        "sigma_first": centre_sigmas(first, num_cameras).tolist(),
        # what a prediction's uncertainty is does not depend on the gauge
        "prediction_difference": float(np.max(np.abs(J @ (free - first) @ J.T))),
    }


def measure(quick: bool) -> Result:
    r = np.linspace(0.0, 6.0, 121)
    outliers = measure_outliers(quick)
    gauge = measure_gauge(quick)
    print_table(
        ("loss", "outliers", "error of centres (m)"),
        ((row["loss"], row["outliers"], row["error_m"]) for row in outliers),
    )
    print_table(
        ("gauge", "unknowns", "final cost"),
        ((row["gauge"], row["unknowns"], f"{row['final_cost']:.9f}") for row in gauge["rows"]),
    )
    print(f"null space at the optimum, intrinsics held: {gauge['null_space']}")
    return {
        "r": r.tolist(),
        "losses": [sample_loss(text, r) for text in LOSSES],
        "outliers": outliers,
        "gauge": gauge,
    }


def draw_robust(result: Result) -> Figure:
    figure = style.new_figure(
        11.0, 4.1, "Robust losses", "loss : scale in px [: degrees of freedom]"
    )
    rho, weight, error = figure.subplots(1, 3)
    for loss, line in zip(result["losses"], STYLES, strict=True):
        look = {**line, "marker": ""}
        rho.plot(result["r"], loss["rho"], **look, label=loss["loss"])
        weight.plot(result["r"], loss["weight"], **look)
        own = [row for row in result["outliers"] if row["loss"] == loss["loss"]]
        error.semilogy(
            [100 * row["outliers"] for row in own], [row["error_m"] for row in own], **line, ms=4.5
        )
    rho.set_ylim(0, 14)
    rho.set_title("Loss: ρ(r²)")
    weight.set_title("Weight of an observation: ρ′(r²)")
    for axes in (rho, weight):
        axes.set_xlabel("residual r (px)")
    error.set_title("Camera centres after adjustment")
    error.set_xlabel("outliers (%)")
    error.set_xticks([100 * fraction for fraction in OUTLIERS])
    error.set_ylabel("RMS distance to the truth (m)")
    style.legend_below(figure, rho)
    return figure


def draw_gauge(result: Result) -> Figure:
    gauge = result["gauge"]
    figure = style.new_figure(10.0, 4.1, "Gauge", "three choices, one cost")
    cost, sigma = figure.subplots(1, 2)
    best = min(row["final_cost"] for row in gauge["rows"])
    for row, line in zip(gauge["rows"], LINES, strict=False):
        excess = np.array(row["costs"]) / best - 1.0
        name = row["gauge"].lower().replace("_", " ")
        label = f"{name}: {row['unknowns']} unknowns"
        cost.semilogy(np.maximum(excess, 1e-12), **line, ms=4.5, label=label)
    cost.set_xlabel("LM iteration")
    cost.set_ylabel("cost / final cost − 1")
    cost.set_title("The same optimum")
    cost.legend(loc="upper right")
    cameras = np.arange(len(gauge["sigma_free"]))
    sigma.plot(cameras, gauge["sigma_free"], **LINES[0], ms=4.5, label="free (pseudo-inverse of H)")
    sigma.plot(
        cameras,
        gauge["sigma_first"],
        **LINES[1],
        ms=4.5,
        label="first camera held (scale: pseudo-inverse)",
    )
    sigma.set_xlabel("camera")
    sigma.set_ylabel("σ of the camera centre, 1 px noise (m)")
    sigma.set_title("Another covariance")
    sigma.set_ylim(0.0, 1.3 * max(gauge["sigma_first"]))
    sigma.legend(loc="upper right")
    return figure


def draw(result: Result) -> dict[str, Figure]:
    return {"robust-losses": draw_robust(result), "gauge": draw_gauge(result)}


if __name__ == "__main__":
    run(__doc__, measure, draw)
