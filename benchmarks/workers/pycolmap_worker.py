"""COLMAP's wheel (its own, newer Ceres): the RADIAL camera is BAL's with +z forward.

`problem` is a folder in COLMAP's binary format (harness.colmap_model writes it), so that reading is
COLMAP's own C++. The trace is what Ceres prints per iteration, the wheel exposes no callback:
costs have seven digits, times three.
"""

import os
import re
import sys
import tempfile
import time

import numpy as np
import pycolmap

from protocol import parse_arguments, report, status_bytes

FLIP = np.diag([1.0, -1.0, -1.0])  # BAL looks along −z, COLMAP along +z
# iter, cost, cost_change, |gradient|, |step|, tr_ratio, tr_radius, ls_iter, iter_time, total_time
ROW = re.compile(r"^\s*(\d+)\s+" + r"\s+".join([r"(\S+)"] * 9) + r"\s*$", re.MULTILINE)


def make_options(arguments) -> pycolmap.BundleAdjustmentOptions:
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.refine_principal_point = False
    options.ceres.min_num_residuals_for_cpu_multi_threading = 0
    solver = options.ceres.solver_options
    solver.max_num_iterations = arguments.max_iterations
    solver.function_tolerance = arguments.function_tolerance
    solver.gradient_tolerance = 1e-14
    solver.parameter_tolerance = 1e-14
    solver.max_solver_time_in_seconds = arguments.time_limit
    solver.num_threads = arguments.threads
    solver.minimizer_progress_to_stdout = True
    solver.logging_type = type(solver.logging_type).PER_MINIMIZER_ITERATION
    return options


def captured_stdout(function):
    """(result, text): what C++ code prints during the call as well."""
    sys.stdout.flush()
    kept = os.dup(1)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 1)
        try:
            result = function()
        finally:
            os.dup2(kept, 1)
            os.close(kept)
        file.seek(0)
        return result, file.read().decode()


def parse_trace(text: str) -> list[list[float]]:
    """Ceres' progress table to [[total time, cost]]; the cost of a rejected step is left out."""
    trace: list[list[float]] = []
    for match in ROW.finditer(text):
        cost, seconds = float(match[2]), float(match[10])
        trace.append([seconds, min(cost, trace[-1][1]) if trace else cost])
    return trace


def bal_parameters(reconstruction) -> list[np.ndarray]:
    cameras = np.empty((reconstruction.num_images(), 9))
    for i, row in enumerate(cameras):
        image = reconstruction.images[i + 1]
        pose = image.cam_from_world().matrix()
        R_cw = FLIP @ pose[:, :3]
        f, _, _, k1, k2 = reconstruction.cameras[i + 1].params
        row[:] = [*log_so3(R_cw), *(FLIP @ pose[:, 3]), f, k1, k2]
    points = reconstruction.points3D
    return [cameras, np.array([points[j].xyz for j in sorted(points)])]


def log_so3(R: np.ndarray) -> np.ndarray:
    q = pycolmap.Rotation3d(R).quat  # xyzw
    angle = 2.0 * np.arctan2(np.linalg.norm(q[:3]), q[3])
    sine = np.linalg.norm(q[:3])
    return q[:3] * (2.0 if sine < 1e-300 else angle / sine)


def main() -> None:
    baseline_bytes = status_bytes("VmRSS")
    arguments = parse_arguments(("auto",))
    start = time.perf_counter()
    reconstruction = pycolmap.Reconstruction(str(arguments.problem))
    parse_s = time.perf_counter() - start
    start = time.perf_counter()
    config = pycolmap.BundleAdjustmentConfig()
    for image_id in reconstruction.reg_image_ids():
        config.add_image(image_id)
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(
        make_options(arguments), config, reconstruction
    )
    build_s = time.perf_counter() - start
    start = time.perf_counter()
    summary, text = captured_stdout(adjuster.solve)
    solve_s = time.perf_counter() - start
    peak_bytes = status_bytes("VmHWM")
    ceres = summary.ceres_summary
    report(
        arguments,
        bal_parameters(reconstruction),
        parse_s=parse_s,
        build_s=build_s,
        preprocess_s=ceres.preprocessor_time_in_seconds,
        solve_s=solve_s,
        trace=parse_trace(text),
        baseline_bytes=baseline_bytes,
        peak_bytes=peak_bytes,
        jacobian_s=ceres.jacobian_evaluation_time_in_seconds,
        residual_s=ceres.residual_evaluation_time_in_seconds,
        linear_solver_s=ceres.linear_solver_time_in_seconds,
        linear_solver=ceres.linear_solver_type_used.name.lower(),
        num_residuals=ceres.num_residuals,
        message=f"pycolmap {pycolmap.__version__}, Ceres {pycolmap.__ceres_version__}: "
        f"{ceres.message}",
    )


if __name__ == "__main__":
    main()
