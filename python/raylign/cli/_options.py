"""The options of `raylign bundle`, and how they become the library's options and config."""

from typing import Annotated

import typer

from raylign.bundle import (
    Backend,
    BundleConfig,
    BundleOptions,
    ConstantCoordinate,
    Gauge,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    ParameterKind,
    PointParametrization,
    PoseParametrization,
    Preconditioner,
)
from raylign.cli import _choices as choices
from raylign.errors import OptionsError
from raylign.robust import Loss

_SOLVER = "Solver"
_FIXED = "What is held fixed"
_LM = "Levenberg-Marquardt"

_DEFAULTS = LmOptions()
_LINEAR_DEFAULTS = LinearSolverOptions()


def _option(panel: str, *names: str, help: str) -> object:
    return typer.Option(*names, help=help, rich_help_panel=panel)


LossOpt = Annotated[
    str, _option(_SOLVER, "--loss", help="type[:scale px[:dof]], e.g. huber:1.0, student_t:1:5.")
]
BackendOpt = Annotated[choices.Backend, _option(_SOLVER, "--backend", help="Engine.")]
PoseOpt = Annotated[choices.Pose, _option(_SOLVER, "--pose", help="How a camera pose moves.")]
PointOpt = Annotated[choices.Point, _option(_SOLVER, "--point", help="How a point moves.")]
LinearSolverOpt = Annotated[
    choices.LinearSolver,
    _option(_SOLVER, "--linear-solver", help="How the normal equations are solved."),
]
PreconditionerOpt = Annotated[
    choices.Precondition, _option(_SOLVER, "--preconditioner", help="Of iterative_schur.")
]
ExplicitSchurOpt = Annotated[
    bool, _option(_SOLVER, "--explicit-schur", help="Form S in iterative_schur with schur_jacobi.")
]
MaxLinearOpt = Annotated[
    int,
    _option(_SOLVER, "--max-num-linear-iterations", help="Conjugate-gradient iterations per step."),
]
ForcingOpt = Annotated[
    float, _option(_SOLVER, "--forcing-tolerance", help="Relative tolerance of an inexact step.")
]
NumThreadsOpt = Annotated[int, _option(_SOLVER, "--num-threads", help="Threads.")]

GaugeOpt = Annotated[
    choices.GaugeChoice, _option(_FIXED, "--gauge", help="What removes the similarity freedom.")
]
FixIntrinsicsOpt = Annotated[
    bool, _option(_FIXED, "--fix-intrinsics", help="Hold f, k1, k2 of every camera.")
]
ConstantCamerasOpt = Annotated[
    str, _option(_FIXED, "--constant-cameras", help="Poses to hold: e.g. 0,3,10-20 or all.")
]
ConstantIntrinsicsOpt = Annotated[
    str, _option(_FIXED, "--constant-intrinsics", help="Cameras whose f, k1, k2 are held.")
]
ConstantPointsOpt = Annotated[str, _option(_FIXED, "--constant-points", help="Points to hold.")]
ConstantCoordinateOpt = Annotated[
    list[str] | None,
    _option(
        _FIXED,
        "--constant-coordinate",
        help="kind:index:coordinate, e.g. intrinsics:all:k2 or pose:4:tz. May be repeated.",
    ),
]

MaxIterationsOpt = Annotated[
    int, _option(_LM, "--max-num-iterations", help="Iterations; 0 only evaluates the cost.")
]
MaxTimeOpt = Annotated[float, _option(_LM, "--max-solver-time-s", help="Wall time limit, s.")]
FunctionToleranceOpt = Annotated[
    float, _option(_LM, "--function-tolerance", help="Stop when |cost change| <= tol * cost.")
]
GradientToleranceOpt = Annotated[
    float, _option(_LM, "--gradient-tolerance", help="Stop when max |gradient| <= tol.")
]
ParameterToleranceOpt = Annotated[
    float, _option(_LM, "--parameter-tolerance", help="Stop when |step| <= tol * |x|.")
]
InitialLambdaOpt = Annotated[
    float, _option(_LM, "--initial-lambda", help="Damping of the first step.")
]


def bundle_options(
    *,
    loss: str,
    backend: choices.Backend,
    pose: choices.Pose,
    point: choices.Point,
    linear_solver: LinearSolverOptions,
    lm: LmOptions,
) -> BundleOptions:
    """Build the library's options from the command line's words."""
    return BundleOptions(
        backend=choices.library_value(Backend, backend),
        pose_parametrization=choices.library_value(PoseParametrization, pose),
        point_parametrization=choices.library_value(PointParametrization, point),
        loss=Loss.parse(loss),
        lm=lm,
        linear_solver=linear_solver,
    )


def linear_solver_options(
    kind: choices.LinearSolver,
    preconditioner: choices.Precondition,
    explicit_schur: bool,
    max_num_iterations: int,
    forcing_tolerance: float,
) -> LinearSolverOptions:
    """Build the linear solver's options."""
    return LinearSolverOptions(
        type=choices.library_value(LinearSolverType, kind),
        preconditioner=choices.library_value(Preconditioner, preconditioner),
        explicit_schur=explicit_schur,
        max_num_iterations=max_num_iterations,
        forcing_tolerance=forcing_tolerance,
    )


def bundle_config(
    *,
    gauge: choices.GaugeChoice,
    num_cameras: int,
    num_points: int,
    cameras: str,
    intrinsics: str,
    points: str,
    coordinates: list[str],
) -> BundleConfig:
    """Build the config from index lists like `0,3,10-20` or `all`."""
    return BundleConfig(
        gauge=choices.library_value(Gauge, gauge),
        constant_cameras=parse_indices(cameras, num_cameras),
        constant_intrinsics=parse_indices(intrinsics, num_cameras),
        constant_points=parse_indices(points, num_points),
        constant_coordinates=[_constant_coordinate(text) for text in coordinates],
    )


def parse_indices(text: str, count: int) -> list[int]:
    """Read `""`, `all`, `7` or `0,3,10-20` (ends included) as a sorted list in [0, count).

    Raises:
        OptionsError: not such a list, or an index outside.
    """
    if not text:
        return []
    if text == "all":
        return list(range(count))
    chosen: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise OptionsError(f"'{text}' is no list of indices like 0,3,10-20 or all")
        low, high = int(first), int(last) if dash else int(first)
        if low > high or high >= count:
            raise OptionsError(f"indices {part.strip()} of '{text}' are not in 0..{count - 1}")
        chosen.update(range(low, high + 1))
    return sorted(chosen)


def _constant_coordinate(text: str) -> ConstantCoordinate:
    kind, _, rest = text.partition(":")
    index, _, coordinate = rest.partition(":")
    kinds = {member.name.lower(): member for member in ParameterKind}
    if kind not in kinds or not coordinate or not (index == "all" or index.isdecimal()):
        raise OptionsError(
            f"'{text}' is not kind:index:coordinate, e.g. intrinsics:all:k2; "
            f"kinds: {', '.join(kinds)}"
        )
    return ConstantCoordinate(
        kind=kinds[kind],
        index=-1 if index == "all" else int(index),  # -1: every camera or point
        coordinate=coordinate,
    )
