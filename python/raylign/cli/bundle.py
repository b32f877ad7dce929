"""`raylign bundle`: refine a BAL problem."""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

import raylign.bundle as library
from raylign.bundle import BundleConfig, BundleOptions, BundleResult, LmOptions, Termination
from raylign.cli import _choices as choices
from raylign.cli import _options as opt
from raylign.cli._console import make_console, say, warn
from raylign.cli._errors import EXIT_INTERRUPTED
from raylign.cli._files import (
    PLY_SUFFIXES,
    check_distinct,
    check_problem_target,
    check_report_target,
    read_problem,
    write_problem,
)
from raylign.cli._progress import SolveDisplay
from raylign.errors import Error
from raylign.scene import BalProblem

_LM = LmOptions()
_LINEAR = library.LinearSolverOptions()
_ITERATIVE_ONLY = (
    "preconditioner",
    "explicit_schur",
    "max_num_linear_iterations",
    "forcing_tolerance",
)
_MAX_CAMERAS_FACTORED = 1000  # with more, `auto` is iterative_schur


@dataclass(frozen=True)
class Outputs:
    """What a solve shall leave behind; None: not wanted."""

    problem: Path | None = None
    ply_before: Path | None = None
    ply_after: Path | None = None
    report: Path | None = None

    def check(self, source: Path) -> None:
        """Raise before the solve what could not be written after it."""
        check_distinct(source, [self.problem, self.ply_before, self.ply_after, self.report])
        if self.problem is not None:
            check_problem_target(self.problem)
        for path in (self.ply_before, self.ply_after):
            if path is not None:
                check_problem_target(path, PLY_SUFFIXES)
        if self.report is not None:
            check_report_target(self.report)


def bundle(
    context: typer.Context,
    problem: Annotated[Path, typer.Argument(help="BAL text (.txt, .gz, .bz2) or .npz.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Refined problem (BAL, .npz or .ply).")
    ] = None,
    ply: Annotated[
        tuple[Path, Path] | None,
        typer.Option("--ply", metavar="BEFORE AFTER", help="Point clouds with cameras, two files."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="Folder for pictures and summary.json.")
    ] = None,
    loss: opt.LossOpt = "trivial",
    backend: opt.BackendOpt = choices.Backend.AUTO,
    pose: opt.PoseOpt = choices.Pose.SE3,
    point: opt.PointOpt = choices.Point.XYZ,
    linear_solver: opt.LinearSolverOpt = choices.LinearSolver.AUTO,
    preconditioner: opt.PreconditionerOpt = choices.Precondition.AUTO,
    explicit_schur: opt.ExplicitSchurOpt = False,
    max_num_linear_iterations: opt.MaxLinearOpt = _LINEAR.max_num_iterations,
    forcing_tolerance: opt.ForcingOpt = _LINEAR.forcing_tolerance,
    jacobian_storage: opt.JacobianStorageOpt = choices.Storage.AUTO,
    parity: opt.ParityOpt = False,
    num_threads: opt.NumThreadsOpt = _LM.num_threads,
    gauge: opt.GaugeOpt = choices.GaugeChoice.FREE,
    fix_intrinsics: opt.FixIntrinsicsOpt = False,
    constant_cameras: opt.ConstantCamerasOpt = None,
    constant_intrinsics: opt.ConstantIntrinsicsOpt = None,
    constant_points: opt.ConstantPointsOpt = None,
    constant_coordinate: opt.ConstantCoordinateOpt = None,
    max_num_iterations: opt.MaxIterationsOpt = _LM.max_num_iterations,
    max_solver_time_s: opt.MaxTimeOpt = _LM.max_solver_time_s,
    function_tolerance: opt.FunctionToleranceOpt = _LM.function_tolerance,
    gradient_tolerance: opt.GradientToleranceOpt = _LM.gradient_tolerance,
    parameter_tolerance: opt.ParameterToleranceOpt = _LM.parameter_tolerance,
    initial_lambda: opt.InitialLambdaOpt = _LM.initial_lambda,
    normalize: Annotated[
        bool, typer.Option("--normalize", help="Solve in normalised coordinates, undone on output.")
    ] = False,
    duplicates: opt.DuplicatesOpt = choices.Duplicates.ERROR,
    log: opt.LogOpt = choices.LogStyle.TABLE,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Refine cameras and points of a BAL problem; Ctrl-C stops and keeps the best state."""
    before_ply, after_ply = ply if ply is not None else (None, None)
    outputs = Outputs(output, before_ply, after_ply, report)
    outputs.check(problem)
    options = opt.bundle_options(
        loss=loss,
        backend=backend,
        pose=pose,
        point=point,
        linear_solver=opt.linear_solver_options(
            linear_solver,
            preconditioner,
            explicit_schur,
            max_num_linear_iterations,
            forcing_tolerance,
        ),
        jacobian_storage=jacobian_storage,
        parity=parity,
        lm=LmOptions(
            max_num_iterations=max_num_iterations,
            max_solver_time_s=max_solver_time_s,
            function_tolerance=function_tolerance,
            gradient_tolerance=gradient_tolerance,
            parameter_tolerance=parameter_tolerance,
            initial_lambda=initial_lambda,
            num_threads=num_threads,
        ),
    )
    before = read_problem(problem, duplicates)
    if not quiet:
        warn_of_unused_options(context, before.num_cameras)
    config = opt.bundle_config(
        gauge=gauge,
        num_cameras=before.num_cameras,
        num_points=before.num_points,
        cameras=constant_cameras,
        intrinsics="all" if fix_intrinsics else constant_intrinsics,
        points=constant_points,
        coordinates=constant_coordinate or [],
    )
    console = make_console(quiet=quiet)
    say(console, f"{problem.name}: {describe(before)}")
    result = solve(before, config, options, console=console, log=log, normalize=normalize)
    finish(before, result, outputs, console, options=options, config=config, name=problem.name)


def describe(problem: BalProblem) -> str:
    """One line: sizes and RMSE."""
    return (
        f"{problem.num_cameras} cameras, {problem.num_points} points, "
        f"{problem.num_observations} observations"
    )


def solve(
    problem: BalProblem,
    config: BundleConfig,
    options: BundleOptions,
    *,
    console: Console,
    log: choices.LogStyle = choices.LogStyle.TABLE,
    normalize: bool = False,
) -> BundleResult[BalProblem]:
    """Run `adjust` with a live display, in normalised coordinates when asked to."""
    import numpy as np

    start, S_nw = problem.normalized() if normalize else (problem, None)
    display = SolveDisplay(console, log, options.lm.max_num_iterations)
    with display.running():
        result = library.adjust(start, config=config, options=options, callback=display)
    if S_nw is None:
        return result
    return BundleResult(result.problem.transformed(np.linalg.inv(S_nw)), result.summary)


def warn_of_unused_options(context: typer.Context, num_cameras: int) -> None:
    """Say which options of the command line have no effect beside the others."""

    def given(name: str) -> bool:
        source = context.get_parameter_source(name)
        return source is not None and source.name == "COMMANDLINE"

    solver = context.params["linear_solver"]
    factored = (
        context.params["backend"] is choices.Backend.CERES and num_cameras <= _MAX_CAMERAS_FACTORED
    )
    automatic = solver is choices.LinearSolver.AUTO and not factored
    if not automatic and solver is not choices.LinearSolver.ITERATIVE_SCHUR:
        for name in _ITERATIVE_ONLY:
            if given(name):
                option = "--" + name.replace("_", "-")
                warn(f"{option} has no effect: --linear-solver {solver} is not iterative here")
    if context.params["fix_intrinsics"] and given("constant_intrinsics"):
        warn("--constant-intrinsics has no effect beside --fix-intrinsics")


def finish(
    before: BalProblem,
    result: BundleResult[BalProblem],
    outputs: Outputs,
    console: Console,
    *,
    options: BundleOptions,
    config: BundleConfig,
    name: str,
) -> None:
    """Say how it went, write every output, and exit with 130 after Ctrl-C.

    Raises:
        Error: the solve failed; nothing is written.
        KeyboardInterrupt: stopped again while writing; the message says what is missing.
        typer.Exit: it was stopped by the user.
    """
    summary = result.summary
    if not summary.is_usable():
        raise Error(f"the solve failed, nothing was written: {summary.message}")
    say(console, summary.brief_report())
    _say_statistics(before, result, console)
    if summary.termination is Termination.MAX_ITERATIONS and options.lm.max_num_iterations > 0:
        limit = options.lm.max_num_iterations
        hint = f"stopped by --max-num-iterations {limit}, not converged: more may lower the cost"
        say(console, hint, style="yellow")

    def write_report() -> str:
        from raylign.viz import bundle_report  # matplotlib: only when pictures are wanted

        assert outputs.report is not None
        with console.status("drawing"):
            bundle_report(
                before, result.problem, summary, outputs.report,
                options=options, config=config, title=f"Bundle adjustment of {name}",
            )  # fmt: skip
        return ""

    jobs: list[tuple[Path, Callable[[], str]]] = []
    for path, problem in (
        (outputs.problem, result.problem),
        (outputs.ply_before, before),
        (outputs.ply_after, result.problem),
    ):
        if path is not None:
            jobs.append((path, functools.partial(write_problem, problem, path)))
    if outputs.report is not None:
        jobs.append((outputs.report / "index.html", write_report))
    _write_all(jobs, console)
    if summary.termination is Termination.USER_STOPPED:
        say(console, "stopped by Ctrl-C: the best state so far is kept", style="yellow")
        raise typer.Exit(EXIT_INTERRUPTED)


def _say_statistics(before: BalProblem, result: BundleResult[BalProblem], console: Console) -> None:
    old, new = before.statistics(), result.problem.statistics()
    text = (
        f"RMSE {old.rmse:.4g} -> {new.rmse:.4g} px per coordinate, "
        f"median error {old.median_error:.4g} -> {new.median_error:.4g} px"
    )
    behind = (old.num_behind_camera, new.num_behind_camera)
    say(console, text)
    if any(behind):
        say(console, f"observations of points behind their camera {behind[0]} -> {behind[1]}")


def _write_all(jobs: list[tuple[Path, Callable[[], str]]], console: Console) -> None:
    """Write one after the other, so that an interruption leaves a true account of what exists."""
    for position, (path, write) in enumerate(jobs):
        try:
            note = write()
        except KeyboardInterrupt:
            missing = ", ".join(str(later) for later, _ in jobs[position:])
            raise KeyboardInterrupt(f"interrupted, not written: {missing}") from None
        say(console, f"wrote {path}{note}")
