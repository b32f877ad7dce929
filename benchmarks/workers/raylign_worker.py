"""raylign, both engines. Solvers: `native:auto`, `native:parity`, `ceres:sparse_schur`, ..."""

import time

import raylign
from protocol import parse_arguments, report, status_bytes

BACKENDS = {name: raylign.bundle.Backend[name.upper()] for name in ("native", "ceres")}
TYPES = {kind.name.lower(): kind for kind in raylign.bundle.LinearSolverType}
EXPLICIT = "iterative_explicit"  # ITERATIVE_SCHUR with S formed
PARITY = "parity"  # AUTO with the steps of Ceres


def make_options(arguments) -> raylign.bundle.BundleOptions:
    backend, solver = arguments.solver.split(":")
    return raylign.bundle.BundleOptions(
        backend=BACKENDS[backend],
        parity=solver == PARITY,
        pose_parametrization=raylign.bundle.PoseParametrization.ANGLE_AXIS,
        linear_solver=raylign.bundle.LinearSolverOptions(
            type=TYPES[{EXPLICIT: "iterative_schur", PARITY: "auto"}.get(solver, solver)],
            explicit_schur=solver == EXPLICIT,
        ),
        lm=raylign.bundle.LmOptions(
            max_num_iterations=arguments.max_iterations,
            max_solver_time_s=arguments.time_limit,
            function_tolerance=arguments.function_tolerance,
            gradient_tolerance=1e-14,
            parameter_tolerance=1e-14,
            num_threads=arguments.threads,
        ),
    )


def main() -> None:
    baseline_bytes = status_bytes("VmRSS")
    arguments = parse_arguments(
        tuple(
            f"{backend}:{solver}" for backend in BACKENDS for solver in (*TYPES, EXPLICIT, PARITY)
        )
    )
    start = time.perf_counter()
    problem = raylign.io.read_bal(arguments.problem)
    parse_s = time.perf_counter() - start
    start = time.perf_counter()
    result = raylign.bundle.adjust(problem, options=make_options(arguments))
    solve_s = time.perf_counter() - start
    peak_bytes = status_bytes("VmHWM")
    summary = result.summary
    rows = summary.iterations
    report(
        arguments,
        [result.problem.cameras, result.problem.points],
        parse_s=parse_s,
        build_s=0.0,
        preprocess_s=summary.preprocessor_time_s,
        solve_s=solve_s,
        trace=[[float(row["cumulative_time_s"]), float(row["cost"])] for row in rows],
        baseline_bytes=baseline_bytes,
        peak_bytes=peak_bytes,
        jacobian_s=summary.jacobian_time_s,
        residual_s=summary.residual_time_s,
        linear_solver_s=summary.linear_solver_time_s,
        linear_solver=f"{summary.linear_solver.name.lower()}: {summary.linear_solver_reason}",
        linear_iterations=[int(row["linear_solver_iterations"]) for row in rows],
        num_residuals=summary.num_residuals,
        message=f"{summary.termination.name}: {summary.message}",
    )


if __name__ == "__main__":
    main()
