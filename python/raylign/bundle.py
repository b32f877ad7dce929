"""Reprojection bundle adjustment of `BalProblem` and `BundleProblem`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from raylign import _core
from raylign._core import (
    Backend,
    BalProblem,
    BundleConfig,
    BundleOptions,
    BundleProblem,
    ConstantCoordinate,
    Gauge,
    IterationSummary,
    JacobianStorage,
    Linearization,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    ParameterKind,
    PointParametrization,
    PoseParametrization,
    Preconditioner,
    Summary,
    Termination,
)

__all__ = [
    "Backend",
    "BundleConfig",
    "BundleOptions",
    "BundleResult",
    "ConstantCoordinate",
    "Gauge",
    "IterationSummary",
    "JacobianStorage",
    "LinearSolverOptions",
    "LinearSolverType",
    "Linearization",
    "LmOptions",
    "ParameterKind",
    "PointParametrization",
    "PoseParametrization",
    "Preconditioner",
    "Summary",
    "Termination",
    "adjust",
    "linearize",
]


ProblemT = TypeVar("ProblemT", BalProblem, BundleProblem)


@dataclass(frozen=True)
class BundleResult(Generic[ProblemT]):
    """What `adjust` returns.

    Attributes:
        problem: refined problem, a new object of the input's class; the input bit by bit when no
            step was accepted.
        summary: costs in px², times in s, one row per iteration.
    """

    problem: ProblemT
    summary: Summary


def adjust(
    problem: ProblemT,
    *,
    config: BundleConfig | None = None,
    options: BundleOptions | None = None,
    callback: Callable[[IterationSummary], bool | None] | None = None,
) -> BundleResult[ProblemT]:
    """Refine cameras and points by minimising the robust reprojection error.

    Minimises ½ Σ ρ(‖π(R_cw X + t_cw; intrinsics) − u‖²) over poses, intrinsics and points.

    Args:
        problem: BalProblem, or BundleProblem for other cameras; not modified.
        config: what is held fixed. Default: nothing (gauge `FREE`; the damping holds it).
        options: how to solve. Default: `BundleOptions()`: the native engine where it has what is
            asked for, else Ceres; `summary.backend_reason` says why.
        callback: called after each iteration, the start included; return False to stop. An
            exception in it stops the solve and is raised again here.

    Returns:
        BundleResult: refined `problem` and `summary`. Ctrl-C, a stop by the callback and the time
        limit return the best state found so far, with `summary.termination` saying so. Numerical
        failure is `Termination.FAILURE` with a message, not an exception.

    Raises:
        OptionsError: an option or an index in `config` is out of range.
        ShapeError: the problem's arrays disagree.

    Note:
        Bitwise reproducible at `num_threads=1`, the default, and where `summary.backend` is
        'native' at any number of threads. Releases the GIL.

    Source:
        Triggs et al., Bundle Adjustment - A Modern Synthesis, 2000; Agarwal et al., ECCV 2010.

    Example:
        >>> import raylign
        >>> problem = raylign.synthetic.bal(num_cameras=10, num_points=200, seed=1).problem
        >>> result = adjust(problem)
        >>> result.summary.final_cost < 0.01 * result.summary.initial_cost
        True
    """
    refined = problem.copy()
    summary = _core.adjust(
        refined,
        config=BundleConfig() if config is None else config,
        options=BundleOptions() if options is None else options,
        callback=callback,
    )
    return BundleResult(problem=refined, summary=summary)


def linearize(
    problem: BalProblem | BundleProblem,
    *,
    config: BundleConfig | None = None,
    options: BundleOptions | None = None,
) -> Linearization:
    """Linearise the bundle-adjustment problem at its current state.

    Args:
        problem: BalProblem or BundleProblem; not modified.
        config: what is held fixed; held coordinates have no column.
        options: parametrisations and loss; the rest is not used.

    Returns:
        Linearization: `cost` (px²), weighted `residuals` (2N,), `gradient` (n,) and J in
        compressed row storage (`row_starts`, `columns`, `values`):
        `scipy.sparse.csr_matrix((values, columns, row_starts), shape=(2N, n))`.
        Columns: per camera pose [υ; ω] then intrinsics; then points.

    Raises:
        OptionsError: an option or an index in `config` is out of range.
        ShapeError: the problem's arrays disagree.
        Error: a residual is not finite at the current state.
    """
    return _core.linearize(
        problem,
        config=BundleConfig() if config is None else config,
        options=BundleOptions() if options is None else options,
    )
