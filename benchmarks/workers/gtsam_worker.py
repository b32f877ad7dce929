"""GTSAM's wheel: general SFM factors, its Sfm Levenberg-Marquardt with Ceres-style damping."""

import time
from importlib.metadata import version

import gtsam
import numpy as np

from protocol import parse_arguments, report, status_bytes

FLIP = np.diag([1.0, -1.0, -1.0])  # BAL looks along −z, GTSAM along +z


def log_so3(R: np.ndarray) -> np.ndarray:
    return gtsam.Rot3.Logmap(gtsam.Rot3(R))


def bal_camera(camera) -> list[float]:
    """GTSAM's camera as nine BAL numbers."""
    R_wc = camera.pose().rotation().matrix()
    R_cw = FLIP @ R_wc.T
    t_cw = -R_cw @ camera.pose().translation()
    calibration = camera.calibration()
    return [*log_so3(R_cw), *t_cw, calibration.fx(), calibration.k1(), calibration.k2()]


def make_parameters(arguments) -> "gtsam.SfmLevenbergMarquardtParams":
    parameters = gtsam.SfmLevenbergMarquardtParams.ceresDefaults()
    mode = gtsam.SfmEliminationMode
    parameters.setEliminationMode(mode.Schur if arguments.solver == "schur" else mode.Full)
    return parameters


def solve(optimizer, arguments, start: float) -> tuple[list[list[float]], str]:
    """(trace, why it ended); iterate() is one accepted step with all its damping trials."""
    trace = [[time.perf_counter() - start, optimizer.error()]]
    for _ in range(arguments.max_iterations):
        try:
            optimizer.iterate()
        except RuntimeError as error:  # thrown by GTSAM without a message; its values are usable
            return trace, f"iterate() raised {error!r}"
        trace.append([time.perf_counter() - start, optimizer.error()])
        change = trace[-2][1] - trace[-1][1]
        if change <= arguments.function_tolerance * trace[-1][1]:
            return trace, "function tolerance"
        if trace[-1][0] > arguments.time_limit:
            return trace, "time limit"
    return trace, "maximum number of iterations"


def main() -> None:
    baseline_bytes = status_bytes("VmRSS")
    arguments = parse_arguments(("schur", "full"))
    start = time.perf_counter()
    data = gtsam.SfmData.FromBalFile(str(arguments.problem))
    parse_s = time.perf_counter() - start
    start = time.perf_counter()
    graph = data.generalSfmFactors(gtsam.noiseModel.Isotropic.Sigma(2, 1.0))
    values = gtsam.initialCamerasAndPointsEstimate(data)
    build_s = time.perf_counter() - start
    start = time.perf_counter()
    optimizer = gtsam.SfmLevenbergMarquardtOptimizer(graph, values, make_parameters(arguments))
    preprocess_s = time.perf_counter() - start
    trace, end = solve(optimizer, arguments, start)
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
        message=f"gtsam {version('gtsam')}: {end}",
    )


if __name__ == "__main__":
    main()
