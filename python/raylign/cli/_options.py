"""The options of `raylign bundle`, and how they become the library's options and config."""

import enum
from typing import Annotated, Any

import typer

from raylign.bundle import (
    Backend,
    BundleConfig,
    BundleOptions,
    ConstantCoordinate,
    Gauge,
    JacobianStorage,
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


def _option(panel: str, *names: str, help: str, metavar: str | None = None) -> object:
    return typer.Option(*names, help=help, rich_help_panel=panel, metavar=metavar)


def choice_option(kind: type[enum.Enum], *names: str, help: str, panel: str | None = None) -> Any:
    """An option for an enumerator in either case; the help text, which may wrap, lists them all."""
    listed = ", ".join(str(member.value) for member in kind)
    return typer.Option(
        *names,
        help=f"{help}: {listed}.",
        metavar="<name>",
        case_sensitive=False,
        rich_help_panel=panel,
    )


LossOpt = Annotated[
    str, _option(_SOLVER, "--loss", help="type[:scale px[:dof]], e.g. huber:1.0, student_t:1:5.")
]
BackendOpt = Annotated[
    choices.Backend, choice_option(choices.Backend, "--backend", help="Engine", panel=_SOLVER)
]
PoseOpt = Annotated[
    choices.Pose,
    choice_option(choices.Pose, "--pose", help="How a camera pose moves", panel=_SOLVER),
]
PointOpt = Annotated[
    choices.Point, choice_option(choices.Point, "--point", help="How a point moves", panel=_SOLVER)
]
JacobianStorageOpt = Annotated[
    choices.Storage,
    choice_option(
        choices.Storage,
        "--jacobian-storage",
        help="How --backend native keeps the Jacobian; auto: float above a million observations",
        panel=_SOLVER,
    ),
]
ParityOpt = Annotated[
    bool, _option(_SOLVER, "--parity", help="--backend native takes the steps of Ceres.")
]
LinearSolverOpt = Annotated[
    choices.LinearSolver,
    choice_option(
        choices.LinearSolver,
        "--linear-solver",
        help="How the normal equations are solved",
        panel=_SOLVER,
    ),
]
PreconditionerOpt = Annotated[
    choices.Precondition,
    choice_option(
        choices.Precondition, "--preconditioner", help="Of iterative_schur", panel=_SOLVER
    ),
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
    choices.GaugeChoice,
    choice_option(
        choices.GaugeChoice, "--gauge", help="What removes the similarity freedom", panel=_FIXED
    ),
]
FixIntrinsicsOpt = Annotated[
    bool, _option(_FIXED, "--fix-intrinsics", help="Hold f, k1, k2 of every camera.")
]
ConstantCamerasOpt = Annotated[
    str | None,
    _option(
        _FIXED,
        "--constant-cameras",
        help="Cameras whose pose is held (f, k1, k2 still move): e.g. 0,3,10-20 or all.",
        metavar="<list>",
    ),
]
ConstantIntrinsicsOpt = Annotated[
    str | None,
    _option(
        _FIXED,
        "--constant-intrinsics",
        help="Cameras whose f, k1, k2 are held.",
        metavar="<list>",
    ),
]
ConstantPointsOpt = Annotated[
    str | None,
    _option(_FIXED, "--constant-points", help="Points to hold.", metavar="<list>"),
]
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

DuplicatesOpt = Annotated[
    choices.Duplicates,
    choice_option(
        choices.Duplicates, "--duplicates", help="When a camera observes a point twice, in any file"
    ),
]
LogOpt = Annotated[
    choices.LogStyle, choice_option(choices.LogStyle, "--log", help="How iterations are printed")
]


def bundle_options(
    *,
    loss: str,
    backend: choices.Backend,
    pose: choices.Pose,
    point: choices.Point,
    linear_solver: LinearSolverOptions,
    jacobian_storage: choices.Storage,
    parity: bool,
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
        jacobian_storage=choices.library_value(JacobianStorage, jacobian_storage),
        parity=parity,
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
    cameras: str | None,
    intrinsics: str | None,
    points: str | None,
    coordinates: list[str],
) -> BundleConfig:
    """Build the config from index lists like `0,3,10-20` or `all`."""
    return BundleConfig(
        gauge=choices.library_value(Gauge, gauge),
        constant_cameras=parse_indices("--constant-cameras", cameras, num_cameras),
        constant_intrinsics=parse_indices("--constant-intrinsics", intrinsics, num_cameras),
        constant_points=parse_indices("--constant-points", points, num_points),
        constant_coordinates=[
            _constant_coordinate(text, num_cameras, num_points) for text in coordinates
        ],
    )


def parse_indices(option: str, text: str | None, count: int) -> list[int]:
    """Read `all`, `7` or `0,3,10-20` (ends included) as a sorted list in [0, count); None: empty.

    Raises:
        OptionsError: not such a list, or an index outside; the message names `option`.
    """
    if text is None:
        return []
    if text == "all":
        return list(range(count))
    chosen: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise OptionsError(f"{option}: '{text}' is no list of indices like 0,3,10-20 or all")
        low, high = int(first), int(last) if dash else int(first)
        if low > high or high >= count:
            raise OptionsError(f"{option}: {part.strip()} in '{text}' is not in 0..{count - 1}")
        chosen.update(range(low, high + 1))
    return sorted(chosen)


def _constant_coordinate(text: str, num_cameras: int, num_points: int) -> ConstantCoordinate:
    kind, _, rest = text.partition(":")
    index, _, coordinate = rest.partition(":")
    kinds = {member.name.lower(): member for member in ParameterKind}
    if kind.lower() not in kinds or not coordinate or not (index == "all" or index.isdecimal()):
        raise OptionsError(
            f"--constant-coordinate: '{text}' is not kind:index:coordinate, "
            f"e.g. intrinsics:all:k2; kinds: {', '.join(kinds)}"
        )
    chosen = kinds[kind.lower()]
    count = num_points if chosen is ParameterKind.POINT else num_cameras
    if index != "all" and int(index) >= count:
        raise OptionsError(f"--constant-coordinate: {index} in '{text}' is not in 0..{count - 1}")
    return ConstantCoordinate(
        kind=chosen,
        index=-1 if index == "all" else int(index),  # -1: every camera or point
        coordinate=coordinate,
    )
