"""`raylign bundle`: refine a BAL problem."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

import raylign.bundle as library
from raylign.bundle import BundleConfig, BundleOptions, BundleResult, LmOptions, Termination
from raylign.cli import _choices as choices
from raylign.cli import _options as opt
from raylign.cli._console import make_console, say
from raylign.cli._errors import EXIT_INTERRUPTED
from raylign.cli._files import (
    PLY_SUFFIXES,
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


@dataclass(frozen=True)
class Outputs:
    """What a solve shall leave behind; None: not wanted."""

    problem: Path | None = None
    ply_before: Path | None = None
    ply_after: Path | None = None
    report: Path | None = None

    def check(self) -> None:
        """Raise before the solve what could not be written after it."""
        if self.problem is not None:
            check_problem_target(self.problem)
        for path in (self.ply_before, self.ply_after):
            if path is not None:
                check_problem_target(path, PLY_SUFFIXES)
        if self.report is not None:
            check_report_target(self.report)


def bundle(
    problem: Annotated[Path, typer.Argument(help="BAL text (.txt, .gz, .bz2) or .npz.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Refined problem (BAL or .npz).")
    ] = None,
    ply: Annotated[
        tuple[Path, Path] | None,
        typer.Option("--ply", metavar="BEFORE AFTER", help="Point clouds with cameras, two files."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="Folder for pictures and summary.json.")
    ] = None,
    loss: opt.LossOpt = "trivial",
    backend: opt.BackendOpt = choices.Backend.CERES,
    pose: opt.PoseOpt = choices.Pose.SE3,
    point: opt.PointOpt = choices.Point.XYZ,
    linear_solver: opt.LinearSolverOpt = choices.LinearSolver.AUTO,
    preconditioner: opt.PreconditionerOpt = choices.Precondition.SCHUR_JACOBI,
    explicit_schur: opt.ExplicitSchurOpt = False,
    max_num_linear_iterations: opt.MaxLinearOpt = _LINEAR.max_num_iterations,
    forcing_tolerance: opt.ForcingOpt = _LINEAR.forcing_tolerance,
    num_threads: opt.NumThreadsOpt = _LM.num_threads,
    gauge: opt.GaugeOpt = choices.GaugeChoice.FREE,
    fix_intrinsics: opt.FixIntrinsicsOpt = False,
    constant_cameras: opt.ConstantCamerasOpt = "",
    constant_intrinsics: opt.ConstantIntrinsicsOpt = "",
    constant_points: opt.ConstantPointsOpt = "",
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
    duplicates: Annotated[
        choices.Duplicates, typer.Option(help="A point observed twice by one camera.")
    ] = choices.Duplicates.ERROR,
    log: Annotated[choices.LogStyle, typer.Option(help="How iterations are printed.")] = (
        choices.LogStyle.TABLE
    ),
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Refine cameras and points of a BAL problem; Ctrl-C stops and keeps the best state."""
    before_ply, after_ply = ply if ply is not None else (None, None)
    outputs = Outputs(output, before_ply, after_ply, report)
    outputs.check()
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
) -> BundleResult:
    """Run `adjust` with a live display, in normalised coordinates when asked to."""
    import numpy as np

    start, S_nw = problem.normalized() if normalize else (problem, None)
    display = SolveDisplay(console, log, options.lm.max_num_iterations)
    with display.running():
        result = library.adjust(start, config=config, options=options, callback=display)
    if S_nw is None:
        return result
    return BundleResult(result.problem.transformed(np.linalg.inv(S_nw)), result.summary)


def finish(
    before: BalProblem,
    result: BundleResult,
    outputs: Outputs,
    console: Console,
    *,
    options: BundleOptions,
    config: BundleConfig,
    name: str,
) -> None:
    """Write every output, say how it went, and exit with 130 after Ctrl-C.

    Raises:
        Error: the solve failed; nothing is written.
        typer.Exit: it was stopped by the user.
    """
    summary = result.summary
    if not summary.is_usable():
        raise Error(f"the solve failed, nothing was written: {summary.message}")
    if outputs.problem is not None:
        write_problem(result.problem, outputs.problem)
    if outputs.ply_before is not None:
        write_problem(before, outputs.ply_before)
    if outputs.ply_after is not None:
        write_problem(result.problem, outputs.ply_after)
    say(console, summary.brief_report())
    if outputs.report is not None:
        from raylign.viz import bundle_report  # matplotlib: only when pictures are wanted

        with console.status("drawing"):
            bundle_report(
                before, result.problem, summary, outputs.report,
                options=options, config=config, title=f"Bundle adjustment of {name}",
            )  # fmt: skip
    _say_where(outputs, console)
    if summary.termination is Termination.USER_STOPPED:
        say(console, "stopped by Ctrl-C: the best state so far is kept", style="yellow")
        raise typer.Exit(EXIT_INTERRUPTED)


def _say_where(outputs: Outputs, console: Console) -> None:
    for path in (outputs.problem, outputs.ply_before, outputs.ply_after):
        if path is not None:
            say(console, f"wrote {path}")
    if outputs.report is not None:
        say(console, f"wrote {outputs.report / 'index.html'} and its pictures")
