"""GTSAM's wheel: general SFM factors under Ceres-style Levenberg-Marquardt damping.

Solvers: `schur`, its optimizer for structure from motion, which eliminates the points first, and
`multifrontal`, its general one.
"""

import time
from importlib.metadata import version

import gtsam
import numpy as np

from protocol import parse_arguments, report, status_bytes

FLIP = np.diag([1.0, -1.0, -1.0])  # BAL looks along −z, GTSAM along +z
MORE_DAMPING = 10.0
MAX_DAMPING = 1e8


def log_so3(R: np.ndarray) -> np.ndarray:
    return gtsam.Rot3.Logmap(gtsam.Rot3(R))


def bal_camera(camera) -> list[float]:
    """GTSAM's camera as nine BAL numbers."""
    R_wc = camera.pose().rotation().matrix()
    R_cw = FLIP @ R_wc.T
    t_cw = -R_cw @ camera.pose().translation()
    calibration = camera.calibration()
    return [*log_so3(R_cw), *t_cw, calibration.fx(), calibration.k1(), calibration.k2()]


def make_optimizer(solver: str, graph, values, damping: float | None = None):
    """With GTSAM's imitation of Ceres' damping; `damping`: where it starts, and its least."""
    if solver == "multifrontal":
        kind = gtsam.LevenbergMarquardtOptimizer
        parameters = gtsam.LevenbergMarquardtParams.CeresDefaults()
    else:
        kind = gtsam.SfmLevenbergMarquardtOptimizer
        parameters = gtsam.SfmLevenbergMarquardtParams.ceresDefaults()
        parameters.setEliminationMode(gtsam.SfmEliminationMode.Schur)
    if damping is not None:
        parameters.setlambdaInitial(damping)
        parameters.setlambdaLowerBound(damping)
    return kind(graph, values, parameters)


def solve(arguments, graph, optimizer, start: float):
    """(optimizer, trace, why it ended); iterate() is one accepted step with all its damping trials.

    The optimizer for structure from motion throws, without a message, where the reduced system is
    not positive definite; the general one raises its damping there. Here it goes on from its values
    with more damping, and the time of the failed step counts.
    """
    trace = [[time.perf_counter() - start, optimizer.error()]]
    restarts = 0

    def end(reason: str):
        return optimizer, trace, f"{reason}, {restarts} restarts with more damping"

    while len(trace) <= arguments.max_iterations:
        if time.perf_counter() - start > arguments.time_limit:
            return end("time limit")
        try:
            optimizer.iterate()
        except RuntimeError:
            damping = MORE_DAMPING * optimizer.lambda_()
            if damping > MAX_DAMPING:
                return end("iterate() raised whatever the damping")
            optimizer = make_optimizer(arguments.solver, graph, optimizer.values(), damping)
            restarts += 1
            continue
        trace.append([time.perf_counter() - start, optimizer.error()])
        change = trace[-2][1] - trace[-1][1]
        if change <= arguments.function_tolerance * trace[-1][1]:
            return end("function tolerance")
    return end("maximum number of iterations")


def main() -> None:
    baseline_bytes = status_bytes("VmRSS")
    arguments = parse_arguments(("schur", "multifrontal"))
    start = time.perf_counter()
    data = gtsam.SfmData.FromBalFile(str(arguments.problem))
    parse_s = time.perf_counter() - start
    start = time.perf_counter()
    graph = data.generalSfmFactors(gtsam.noiseModel.Isotropic.Sigma(2, 1.0))
    values = gtsam.initialCamerasAndPointsEstimate(data)
    build_s = time.perf_counter() - start
    start = time.perf_counter()
    optimizer = make_optimizer(arguments.solver, graph, values)
    preprocess_s = time.perf_counter() - start
    optimizer, trace, end = solve(arguments, graph, optimizer, start)
    solve_s = time.perf_counter() - start
    peak_bytes = status_bytes("VmHWM")
    values = optimizer.values()
    point = gtsam.symbol("p", 0)
    cameras = [
        bal_camera(values.atPinholeCameraCal3Bundler(i)) for i in range(data.numberCameras())
    ]
    points = [values.atPoint3(point + j) for j in range(data.numberTracks())]
    report(
        arguments,
        [np.array(cameras), np.array(points)],
        parse_s=parse_s,
        build_s=build_s,
        preprocess_s=preprocess_s,
        solve_s=solve_s,
        trace=trace,
        baseline_bytes=baseline_bytes,
        peak_bytes=peak_bytes,
        linear_solver=arguments.solver,
        message=f"GTSAM {version('gtsam')}: {end}",
    )


if __name__ == "__main__":
    main()
