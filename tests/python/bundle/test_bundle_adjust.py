"""raylign.bundle.adjust: costs, engines, linear solvers, losses."""

import numpy as np
import pytest

import oracle
import raylign
from bundle_cases import BACKENDS, POINTS, TIGHT
from raylign import bundle
from raylign.bundle import (
    Backend,
    BundleOptions,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    PoseParametrization,
    Preconditioner,
    Termination,
)
from raylign.robust import Loss, LossType


def test_cost_goes_down_and_equals_the_independent_evaluator(adjust, perturbed):
    before = perturbed.copy()
    result = adjust(perturbed)
    summary = result.summary
    assert perturbed == before  # the input is not modified
    assert summary.termination is Termination.CONVERGENCE
    assert summary.is_usable()
    assert summary.final_cost < 0.01 * summary.initial_cost
    assert summary.initial_cost == pytest.approx(oracle.cost(before), rel=1e-12)
    assert summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)


def test_summary_tells_the_whole_story(adjust, backend, perturbed):
    summary = adjust(perturbed).summary
    rows = summary.iterations
    assert rows["iteration"].tolist() == list(range(len(rows)))
    assert rows["cost"][0] == summary.initial_cost
    assert rows["cost"][-1] == pytest.approx(summary.final_cost, rel=1e-9)
    assert np.all(np.diff(rows["cost"]) <= 0.0)  # monotonic: no row is worse than the one before
    np.testing.assert_allclose(
        -np.diff(rows["cost"]), rows["cost_change"][1:], rtol=1e-6, atol=1e-9
    )
    assert np.all(np.diff(rows["cumulative_time_s"]) > 0.0)
    assert rows["lambda"][0] == pytest.approx(1e-4)
    assert set(rows["num_residual_blocks"]) == {80}
    assert summary.num_accepted == np.count_nonzero(rows["step_is_accepted"])
    assert summary.num_residuals == 160
    assert summary.num_effective_parameters == 4 * 9 + 20 * 3
    assert summary.backend == backend.name.lower()
    assert summary.linear_solver is LinearSolverType.DENSE_SCHUR
    assert "4 cameras" in summary.linear_solver_reason
    assert "convergence" in summary.brief_report()
    assert "dense_schur" in summary.full_report()


def test_same_input_same_bits(adjust, perturbed):
    first, second = adjust(perturbed), adjust(perturbed)
    assert first.problem == second.problem
    assert first.summary.deterministic
    assert first.summary.iterations["cost"].tobytes() == second.summary.iterations["cost"].tobytes()


@pytest.mark.parametrize("backend", [Backend.NATIVE])
def test_native_gives_the_same_bits_on_any_number_of_threads(adjust):
    problem = raylign.synthetic.bal(num_cameras=20, num_points=3000, seed=2).problem
    reference = adjust(problem)
    for num_threads in (2, 4, 4):
        options = BundleOptions(lm=LmOptions(num_threads=num_threads))
        result = adjust(problem, options=options)
        assert result.problem == reference.problem
        assert result.summary.deterministic
        assert (
            result.summary.iterations["cost"].tobytes()
            == reference.summary.iterations["cost"].tobytes()
        )


@pytest.mark.parametrize("backend", [Backend.NATIVE])
@pytest.mark.parametrize(
    ("options", "field"),
    [
        (BundleOptions(point_parametrization="inverse_depth"), "point_parametrization"),
        (
            BundleOptions(linear_solver=LinearSolverOptions(type="dense_normal_cholesky")),
            "LinearSolverOptions.type",
        ),
    ],
    ids=["inverse depth", "normal equations"],
)
def test_native_refuses_what_it_does_not_do(adjust, perturbed, options, field):
    with pytest.raises(raylign.OptionsError, match=field):
        adjust(perturbed, options=options)


ITERATIVE = LinearSolverOptions(type="iterative_schur")


@pytest.mark.parametrize(
    ("options", "expected", "why"),
    [
        (BundleOptions(), "native", "all that was asked for"),
        (BundleOptions(point_parametrization="homogeneous"), "native", "all that was asked for"),
        (BundleOptions(point_parametrization="inverse_depth"), "ceres", "inverse_depth"),
        (
            BundleOptions(linear_solver=LinearSolverOptions(type="dense_normal_cholesky")),
            "ceres",
            "dense_normal_cholesky",
        ),
        (
            BundleOptions(linear_solver=ITERATIVE.replace(preconditioner="cluster_jacobi")),
            "ceres",
            "cluster_jacobi",
        ),
        (BundleOptions(backend="ceres"), "ceres", "requested"),
        (BundleOptions(backend="native"), "native", "requested"),
    ],
)
def test_the_default_takes_the_native_engine_where_it_has_what_is_asked_for(
    perturbed, options, expected, why
):
    summary = bundle.adjust(perturbed, options=options).summary
    assert summary.termination is Termination.CONVERGENCE
    assert summary.backend == expected
    assert why in summary.backend_reason
    assert summary.backend_reason in summary.full_report()


def test_what_only_the_native_engine_has_is_no_option_elsewhere(perturbed):
    options = BundleOptions(point_parametrization="inverse_depth", jacobian_storage="float")
    with pytest.raises(raylign.OptionsError, match="jacobian_storage FLOAT needs backend NATIVE"):
        bundle.adjust(perturbed, options=options)
    two_level = BundleOptions(linear_solver=ITERATIVE.replace(preconditioner="two_level"))
    with pytest.raises(raylign.OptionsError, match="explicit_schur"):
        bundle.adjust(perturbed, options=two_level)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", ["xyz", "homogeneous"])
def test_both_engines_walk_the_same_path(perturbed, pose, point):
    options = BundleOptions(pose_parametrization=pose, point_parametrization=point, parity=True)
    rows = {
        backend: bundle.adjust(
            perturbed, options=options.replace(backend=backend)
        ).summary.iterations
        for backend in BACKENDS
    }
    count = min(len(r) for r in rows.values())
    assert count >= 4
    for column, rtol in (("cost", 1e-9), ("lambda", 1e-6)):
        np.testing.assert_allclose(
            rows[Backend.NATIVE][column][:count], rows[Backend.CERES][column][:count], rtol=rtol
        )


SCHUR_SOLVERS = [
    LinearSolverOptions(type=LinearSolverType.DENSE_SCHUR),
    LinearSolverOptions(type=LinearSolverType.SPARSE_SCHUR),
    LinearSolverOptions(type=LinearSolverType.DENSE_NORMAL_CHOLESKY),
    *(
        LinearSolverOptions(
            type=LinearSolverType.ITERATIVE_SCHUR, preconditioner=p, forcing_tolerance=1e-6
        )
        for p in Preconditioner
        if p not in (Preconditioner.TWO_LEVEL, Preconditioner.STALE_FACTOR)  # NATIVE's own
    ),
    LinearSolverOptions(
        type=LinearSolverType.ITERATIVE_SCHUR, explicit_schur=True, forcing_tolerance=1e-6
    ),
]


NATIVE_SOLVERS = [
    LinearSolverOptions(type=LinearSolverType.DENSE_SCHUR),
    *(
        LinearSolverOptions(
            type=LinearSolverType.ITERATIVE_SCHUR,
            preconditioner=p,
            explicit_schur=explicit,
            forcing_tolerance=1e-6,
        )
        for p, explicit in (
            (Preconditioner.SCHUR_JACOBI, False),  # by the landmarks, S not formed
            (Preconditioner.SCHUR_JACOBI, True),
            (Preconditioner.TWO_LEVEL, True),
            (Preconditioner.STALE_FACTOR, True),
        )
    ),
]


@pytest.mark.parametrize(
    ("backend", "point", "solver"),
    [
        *((*engine, solver) for engine in POINTS[:3] for solver in SCHUR_SOLVERS),
        *((*engine, solver) for engine in POINTS[3:] for solver in NATIVE_SOLVERS),
    ],
    ids=lambda v: v.name if hasattr(v, "name") else f"{v.type.name}-{v.preconditioner.name}",
)
def test_every_linear_solver_reaches_the_same_cost(adjust, perturbed, solver, point):
    reference = adjust(perturbed, options=BundleOptions(lm=TIGHT)).summary.final_cost
    options = BundleOptions(linear_solver=solver, point_parametrization=point, lm=TIGHT)
    summary = adjust(perturbed, options=options).summary
    assert summary.final_cost == pytest.approx(reference, rel=1e-9)
    assert summary.linear_solver is solver.type
    assert summary.linear_solver_reason == "requested"


@pytest.mark.parametrize(
    "loss", [Loss(type=t, scale=1.5) for t in LossType], ids=lambda x: x.type.name
)
def test_robust_cost_is_the_sum_of_rho(adjust, perturbed, loss):
    perturbed.observations[::17] += 40.0  # outliers
    result = adjust(perturbed, options=BundleOptions(loss=loss))
    for problem, cost in (
        (perturbed, result.summary.initial_cost),
        (result.problem, result.summary.final_cost),
    ):
        s = np.sum(oracle.residuals(problem) ** 2, axis=1)
        rho, _, _ = loss.evaluate(s)
        assert cost == pytest.approx(0.5 * np.sum(rho), rel=1e-12)
    assert result.summary.final_cost < result.summary.initial_cost


def test_robust_loss_shrugs_off_outliers(adjust, perturbed):
    clean = adjust(perturbed, options=BundleOptions(lm=TIGHT)).problem
    perturbed.observations[::17] += 60.0
    inliers = np.ones(80, bool)
    inliers[::17] = False
    errors = {}
    for loss in (Loss(), Loss(type=LossType.CAUCHY, scale=1.0)):
        refined = adjust(perturbed, options=BundleOptions(loss=loss, lm=TIGHT)).problem
        errors[loss.type] = np.sqrt(np.mean(oracle.residuals(refined)[inliers] ** 2))
    best = np.sqrt(np.mean(oracle.residuals(clean)[inliers] ** 2))
    assert errors[LossType.CAUCHY] < 1.2 * best
    assert errors[LossType.TRIVIAL] > 3.0 * best
