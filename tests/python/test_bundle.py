"""raylign.bundle.adjust: what a user relies on, whatever the engine."""

import ctypes
import os
import signal
import threading

import numpy as np
import pytest

import oracle
import raylign
from raylign import bundle
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
    Termination,
)
from raylign.robust import Loss, LossType

TIGHT = LmOptions(
    max_num_iterations=200,
    function_tolerance=1e-14,
    gradient_tolerance=1e-14,
    parameter_tolerance=1e-14,
)


BACKENDS = [Backend.CERES, Backend.NATIVE]
POINTS = [  # what each engine can do
    (Backend.CERES, PointParametrization.XYZ),
    (Backend.CERES, PointParametrization.HOMOGENEOUS),
    (Backend.CERES, PointParametrization.INVERSE_DEPTH),
    (Backend.NATIVE, PointParametrization.XYZ),
    (Backend.NATIVE, PointParametrization.HOMOGENEOUS),
]

ceres_only = pytest.mark.parametrize("backend", [Backend.CERES], ids=["CERES"])


@pytest.fixture(params=BACKENDS, ids=lambda b: b.name)
def backend(request):
    return request.param


@pytest.fixture
def adjust(backend):
    """raylign.bundle.adjust with each engine in turn."""

    def run(problem, *, options=None, **keywords):
        options = (options or BundleOptions()).replace(backend=backend)
        return bundle.adjust(problem, options=options, **keywords)

    return run


@pytest.fixture
def perturbed(tiny_problem):
    rng = np.random.default_rng(3)
    tiny_problem.points[:] += rng.normal(0.0, 0.05, tiny_problem.points.shape)
    tiny_problem.cameras[:, :6] += rng.normal(0.0, 0.01, (4, 6))
    return tiny_problem


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


# --- constants and gauge -------------------------------------------------------------------------


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize(("backend", "point"), POINTS, ids=lambda p: p.name)
def test_constant_blocks_come_back_bit_by_bit(adjust, perturbed, pose, point):
    config = BundleConfig(
        constant_cameras=[1], constant_intrinsics=[0, 2], constant_points=[3, 4, 11]
    )
    options = BundleOptions(pose_parametrization=pose, point_parametrization=point)
    result = adjust(perturbed, config=config, options=options)
    refined = result.problem
    np.testing.assert_array_equal(refined.cameras[1, :6], perturbed.cameras[1, :6])
    np.testing.assert_array_equal(refined.cameras[[0, 2], 6:], perturbed.cameras[[0, 2], 6:])
    np.testing.assert_array_equal(refined.points[[3, 4, 11]], perturbed.points[[3, 4, 11]])
    moved_points = np.setdiff1d(np.arange(20), [3, 4, 11])
    assert np.all(np.any(refined.points[moved_points] != perturbed.points[moved_points], axis=1))
    assert np.all(refined.cameras[[0, 2, 3], :3] != perturbed.cameras[[0, 2, 3], :3])
    assert np.all(refined.cameras[[1, 3], 6:] != perturbed.cameras[[1, 3], 6:])
    assert result.summary.final_cost == pytest.approx(oracle.cost(refined), rel=1e-12)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
def test_constant_coordinates_come_back_bit_by_bit(adjust, perturbed, pose):
    held = [
        ConstantCoordinate(kind=ParameterKind.POSE, index=0, coordinate="rotation"),
        ConstantCoordinate(kind=ParameterKind.POSE, index=1, coordinate="tx"),
        ConstantCoordinate(kind=ParameterKind.POSE, index=1, coordinate="tz"),
        ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate="k2"),
        ConstantCoordinate(kind=ParameterKind.POINT, index=5, coordinate="y"),
    ]
    options = BundleOptions(pose_parametrization=pose)
    refined = adjust(
        perturbed, config=BundleConfig(constant_coordinates=held), options=options
    ).problem
    changed_cameras = refined.cameras != perturbed.cameras
    changed_points = refined.points != perturbed.points
    expected_cameras = np.ones((4, 9), bool)
    expected_cameras[0, :3] = False
    expected_cameras[1, [3, 5]] = False
    expected_cameras[:, 8] = False
    expected_points = np.ones((20, 3), bool)
    expected_points[5, 1] = False
    np.testing.assert_array_equal(changed_cameras, expected_cameras)
    np.testing.assert_array_equal(changed_points, expected_points)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
def test_gauge_choices_reach_the_same_cost(adjust, perturbed, pose):
    costs, freedoms = {}, {}
    for gauge in Gauge:
        options = BundleOptions(pose_parametrization=pose, lm=TIGHT)
        summary = adjust(perturbed, config=BundleConfig(gauge=gauge), options=options).summary
        costs[gauge] = summary.final_cost
        freedoms[gauge] = summary.num_effective_parameters
    assert costs[Gauge.FIRST_CAMERA] == pytest.approx(costs[Gauge.FREE], rel=1e-9)
    assert costs[Gauge.TWO_CAMERAS] == pytest.approx(costs[Gauge.FREE], rel=1e-9)
    assert freedoms[Gauge.FREE] - freedoms[Gauge.FIRST_CAMERA] == 6
    assert freedoms[Gauge.FREE] - freedoms[Gauge.TWO_CAMERAS] == 7


def test_two_cameras_holds_the_largest_coordinate_of_the_longest_baseline(adjust, perturbed):
    refined = adjust(perturbed, config=BundleConfig(gauge=Gauge.TWO_CAMERAS)).problem
    centers = perturbed.camera_centers()
    farthest = int(np.argmax(np.linalg.norm(centers - centers[0], axis=1)))
    R = oracle.rotation_matrices(perturbed.cameras[:, :3])[farthest]
    coordinate = int(np.argmax(np.abs(R @ (centers[farthest] - centers[0]))))
    held = refined.cameras[:, :6] == perturbed.cameras[:, :6]
    expected = np.zeros((4, 6), bool)
    expected[0] = True
    expected[farthest, 3 + coordinate] = True
    np.testing.assert_array_equal(held, expected)


def test_everything_constant_changes_nothing(adjust, perturbed):
    config = BundleConfig(
        constant_cameras=range(4), constant_intrinsics=range(4), constant_points=range(20)
    )
    result = adjust(perturbed, config=config)
    assert result.problem == perturbed
    assert result.summary.final_cost == result.summary.initial_cost
    assert result.summary.termination is Termination.CONVERGENCE
    assert len(result.summary.iterations) == 1


@pytest.mark.parametrize(
    ("config", "field"),
    [
        (BundleConfig(constant_cameras=[4]), "constant_cameras"),
        (BundleConfig(constant_points=[20]), "constant_points"),
        (BundleConfig(constant_intrinsics=[99]), "constant_intrinsics"),
        (
            BundleConfig(constant_coordinates=[ConstantCoordinate(index=7, coordinate="f")]),
            "constant_coordinates",
        ),
    ],
)
def test_an_index_outside_the_problem_is_an_options_error(adjust, perturbed, config, field):
    with pytest.raises(raylign.OptionsError, match=field):
        adjust(perturbed, config=config)


@ceres_only
def test_contradicting_options_are_refused(adjust, perturbed):
    with pytest.raises(raylign.OptionsError, match="explicit_schur"):
        LinearSolverOptions(type=LinearSolverType.DENSE_SCHUR, explicit_schur=True)
    jacobi = LinearSolverOptions(
        type=LinearSolverType.ITERATIVE_SCHUR,
        preconditioner=Preconditioner.JACOBI,
        explicit_schur=True,
    )
    with pytest.raises(raylign.OptionsError, match="explicit_schur"):
        adjust(perturbed, options=BundleOptions(linear_solver=jacobi))
    with pytest.raises(raylign.OptionsError, match="must be one of f, fx, fy"):
        ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate="focal")
    of_a_pinhole = ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate="fx")
    with pytest.raises(raylign.OptionsError, match="must be one of f, k1, k2, got 'fx'"):
        adjust(perturbed, config=BundleConfig(constant_coordinates=[of_a_pinhole]))
    one_coordinate = ConstantCoordinate(kind=ParameterKind.POINT, index=0, coordinate="z")
    with pytest.raises(raylign.OptionsError, match="XYZ"):
        adjust(
            perturbed,
            config=BundleConfig(constant_coordinates=[one_coordinate]),
            options=BundleOptions(point_parametrization=PointParametrization.HOMOGENEOUS),
        )


@ceres_only
def test_dense_normal_equations_refuse_to_fill_the_memory(adjust):
    problem = raylign.synthetic.bal(num_cameras=50, num_points=8000, seed=1).problem
    options = BundleOptions(
        linear_solver=LinearSolverOptions(type=LinearSolverType.DENSE_NORMAL_CHOLESKY)
    )
    with pytest.raises(raylign.OptionsError, match="GB"):
        adjust(problem, options=options)


# --- callback, stop, limits ----------------------------------------------------------------------


def test_callback_sees_every_iteration_in_order(adjust, perturbed):
    seen = []
    summary = adjust(perturbed, callback=lambda it: seen.append((it.iteration, it.cost))).summary
    assert seen == list(
        zip(summary.iterations["iteration"], summary.iterations["cost"], strict=True)
    )


@pytest.mark.parametrize("boolean", [bool, np.bool_])
def test_callback_returning_false_stops_with_the_best_state(adjust, perturbed, boolean):
    result = adjust(perturbed, callback=lambda it: boolean(it.iteration < 2))
    assert result.summary.termination is Termination.USER_STOPPED
    assert len(result.summary.iterations) == 3
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)
    assert result.summary.final_cost < result.summary.initial_cost


@pytest.mark.parametrize("answer", [None, True, 0, 1, "stop"])
def test_only_false_stops(adjust, perturbed, answer):
    summary = adjust(perturbed, callback=lambda it: answer).summary
    assert summary.termination is Termination.CONVERGENCE


def test_exception_in_the_callback_comes_out(adjust, perturbed):
    class MineError(Exception):
        pass

    def callback(iteration):
        if iteration.iteration == 1:
            raise MineError("from the callback")

    before = perturbed.copy()
    with pytest.raises(MineError, match="from the callback"):
        adjust(perturbed, callback=callback)
    assert perturbed == before


def test_ctrl_c_stops_with_the_best_state(adjust, perturbed):
    def callback(iteration):
        if iteration.iteration == 1:
            os.kill(os.getpid(), signal.SIGINT)

    result = adjust(perturbed, callback=callback)
    assert result.summary.termination is Termination.USER_STOPPED
    assert result.summary.final_cost < result.summary.initial_cost
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)


def test_keyboard_interrupt_raised_by_the_callback_is_a_stop(adjust, perturbed):
    def callback(iteration):
        raise KeyboardInterrupt

    assert adjust(perturbed, callback=callback).summary.termination is Termination.USER_STOPPED


def test_other_threads_run_during_a_solve(adjust, perturbed):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(1)
            stop.wait(1e-4)

    thread = threading.Thread(target=tick)
    thread.start()
    seen = []
    try:
        while sum(seen) == 0 and len(seen) < 2000:  # one takes less than a tick
            before = len(ticks)
            adjust(perturbed)
            seen.append(len(ticks) - before)
    finally:
        stop.set()
        thread.join()
    assert sum(seen) > 0


def test_zero_iterations_only_evaluate(adjust, perturbed):
    result = adjust(perturbed, options=BundleOptions(lm=LmOptions(max_num_iterations=0)))
    assert result.problem == perturbed
    assert result.summary.termination is Termination.MAX_ITERATIONS
    assert result.summary.final_cost == result.summary.initial_cost
    assert len(result.summary.iterations) == 1


def test_iteration_and_time_limits_are_told_apart(adjust, perturbed):
    few = adjust(perturbed, options=BundleOptions(lm=LmOptions(max_num_iterations=1))).summary
    assert few.termination is Termination.MAX_ITERATIONS
    late = adjust(perturbed, options=BundleOptions(lm=LmOptions(max_solver_time_s=1e-9))).summary
    assert late.termination is Termination.TIME_LIMIT
    assert late.final_cost <= late.initial_cost


# --- awkward problems ----------------------------------------------------------------------------


def subproblem(problem, keep):
    """The same cameras and points with only some observations."""
    return raylign.BalProblem(
        problem.cameras.copy(),
        problem.points.copy(),
        problem.camera_index[keep].copy(),
        problem.point_index[keep].copy(),
        problem.observations[keep].copy(),
    )


@pytest.mark.parametrize(
    "make",
    [
        lambda p: np.zeros(80, bool),
        lambda p: np.arange(80) == 0,
        lambda p: p.camera_index == 0,
        lambda p: p.point_index == 0,
        lambda p: p.camera_index < 2,
    ],
    ids=["empty", "one observation", "one camera", "one point", "two cameras"],
)
@pytest.mark.parametrize(("backend", "point"), POINTS, ids=lambda p: p.name)
def test_degenerate_problems_give_a_finite_answer(adjust, perturbed, make, point):
    keep = make(perturbed)
    problem = subproblem(perturbed, keep)
    result = adjust(problem, options=BundleOptions(point_parametrization=point))
    assert result.summary.is_usable()
    assert result.summary.final_cost <= result.summary.initial_cost
    assert np.all(np.isfinite(result.problem.cameras))
    assert np.all(np.isfinite(result.problem.points))
    unseen_points = np.setdiff1d(np.arange(20), problem.point_index)
    np.testing.assert_array_equal(
        result.problem.points[unseen_points], problem.points[unseen_points]
    )


def test_duplicate_observations_count_twice(adjust, tiny_problem):
    twice = subproblem(tiny_problem, np.r_[np.arange(80), 7])
    extra = 0.5 * np.sum(oracle.residuals(tiny_problem)[7] ** 2)
    summary = adjust(twice).summary
    assert summary.initial_cost == pytest.approx(oracle.cost(tiny_problem) + extra, rel=1e-12)
    assert summary.is_usable()


@pytest.mark.parametrize("where", ["points", "cameras", "observations"])
def test_nan_at_the_start_is_a_failure_that_names_the_observation(adjust, tiny_problem, where):
    getattr(tiny_problem, where)[2, 0] = np.nan
    before = tiny_problem.copy()
    result = adjust(tiny_problem)
    assert result.summary.termination is Termination.FAILURE
    assert not result.summary.is_usable()
    first = np.flatnonzero(~np.isfinite(oracle.residuals(tiny_problem)).all(axis=1))[0]
    assert f"observation {first} " in result.summary.message
    assert result.problem == before


def test_point_in_the_camera_plane_is_a_failure(adjust, tiny_problem):
    centers = tiny_problem.camera_centers()
    tiny_problem.points[4] = centers[0]
    summary = adjust(tiny_problem).summary
    assert summary.termination is Termination.FAILURE
    assert "point 4" in summary.message


def test_views_with_a_broken_index_are_refused(adjust, tiny_problem):
    tiny_problem.camera_index[3] = 99
    with pytest.raises(raylign.ShapeError, match="camera_index"):
        adjust(tiny_problem)


# --- every parametrisation keeps every promise ----------------------------------------------------


@pytest.mark.parametrize(("backend", "point"), POINTS, ids=lambda p: p.name)
def test_loss_applies_to_every_kind_of_point(adjust, perturbed, point):
    perturbed.observations[::17] += 40.0
    loss = Loss(type=LossType.CAUCHY, scale=1.5)
    options = BundleOptions(loss=loss, point_parametrization=point)
    result = adjust(perturbed, options=options)
    for problem, cost in (
        (perturbed, result.summary.initial_cost),
        (result.problem, result.summary.final_cost),
    ):
        s = np.sum(oracle.residuals(problem) ** 2, axis=1)
        assert cost == pytest.approx(0.5 * np.sum(loss.evaluate(s)[0]), rel=1e-11)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize(("backend", "point"), POINTS, ids=lambda p: p.name)
def test_every_parametrisation_has_the_same_freedoms(adjust, perturbed, pose, point):
    options = BundleOptions(pose_parametrization=pose, point_parametrization=point)
    assert adjust(perturbed, options=options).summary.num_effective_parameters == 4 * 9 + 20 * 3


@ceres_only
def test_points_move_with_the_camera_they_are_anchored_in(adjust, perturbed):
    """Seen once, an inverse-depth point keeps its own numbers while its host moves."""
    keep = (perturbed.point_index >= 5) | (perturbed.camera_index == 0)
    problem = subproblem(perturbed, keep)
    options = BundleOptions(point_parametrization=PointParametrization.INVERSE_DEPTH)
    result = adjust(problem, options=options)
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-10)
    assert np.all(np.any(result.problem.points[:5] != problem.points[:5], axis=1))


@ceres_only
def test_anchor_does_not_depend_on_the_order_of_observations(adjust, perturbed):
    options = BundleOptions(point_parametrization=PointParametrization.INVERSE_DEPTH)
    backwards = subproblem(perturbed, np.arange(80)[::-1])
    a = adjust(perturbed, options=options).summary.iterations["cost"]
    b = adjust(backwards, options=options).summary.iterations["cost"]
    np.testing.assert_allclose(b[:5], a[:5], rtol=1e-9)


@pytest.mark.parametrize(
    "point",
    [PointParametrization.HOMOGENEOUS, PointParametrization.INVERSE_DEPTH],
    ids=lambda p: p.name,
)
@ceres_only
def test_a_point_at_infinity_comes_back_finite(adjust, tiny_problem, point):
    """Parallel rays: the best point is at infinity, w = 0 or ρ = 0; a file holds finite numbers."""
    R = oracle.rotation_matrices(tiny_problem.cameras[:, :3])
    direction = R[0].T @ [0.1, 0.2, -1.0]
    for camera in range(4):
        p = R[camera] @ direction
        f, k1, k2 = tiny_problem.cameras[camera, 6:]
        xy = -p[:2] / p[2]
        r2 = xy @ xy
        tiny_problem.observations[camera * 20 + 3] = f * (1.0 + k1 * r2 + k2 * r2 * r2) * xy
    config = BundleConfig(constant_cameras=range(4), constant_intrinsics=range(4))
    options = BundleOptions(point_parametrization=point, lm=TIGHT)
    result = adjust(tiny_problem, config=config, options=options)
    assert np.all(np.isfinite(result.problem.points))
    assert np.linalg.norm(result.problem.points[3]) > 1e6
    errors = np.linalg.norm(oracle.residuals(result.problem), axis=1)
    assert np.max(errors[tiny_problem.point_index == 3]) < 1e-4


def test_gauge_cameras_are_cameras_with_observations(adjust, perturbed):
    cameras = np.vstack([perturbed.cameras[:1], perturbed.cameras, perturbed.cameras[:1]])
    cameras[-1, 3:6] += 1e6  # far away, and nobody observes anything from it
    problem = raylign.BalProblem(
        np.ascontiguousarray(cameras),
        perturbed.points.copy(),
        (perturbed.camera_index + 1).astype(np.int32),
        perturbed.point_index.copy(),
        perturbed.observations.copy(),
    )
    for gauge, num_held in ((Gauge.FIRST_CAMERA, 6), (Gauge.TWO_CAMERAS, 7)):
        result = adjust(problem, config=BundleConfig(gauge=gauge))
        held = result.problem.cameras[1:5, :6] == problem.cameras[1:5, :6]
        assert held[0].all()
        assert np.count_nonzero(held) == num_held


@pytest.mark.parametrize(
    ("num_cameras", "expected"),
    [
        (200, LinearSolverType.DENSE_SCHUR),
        (201, LinearSolverType.SPARSE_SCHUR),
        (1000, LinearSolverType.SPARSE_SCHUR),
        (1001, LinearSolverType.ITERATIVE_SCHUR),
    ],
)
@ceres_only
def test_auto_chooses_by_the_number_of_cameras(adjust, num_cameras, expected):
    problem = raylign.synthetic.bal(num_cameras=num_cameras, num_points=4 * num_cameras).problem
    summary = adjust(problem, options=BundleOptions(lm=LmOptions(max_num_iterations=0))).summary
    assert summary.linear_solver is expected
    assert f"{num_cameras} cameras" in summary.linear_solver_reason


@ceres_only
def test_without_a_free_point_the_cameras_are_solved_sparsely(adjust, perturbed):
    result = adjust(perturbed, config=BundleConfig(constant_points=range(20)))
    assert result.summary.linear_solver is LinearSolverType.SPARSE_SCHUR
    assert "no free point" in result.summary.linear_solver_reason
    requested = BundleOptions(linear_solver=LinearSolverOptions(type="dense_schur"))
    told = adjust(perturbed, config=BundleConfig(constant_points=range(20)), options=requested)
    assert "Ceres ran DENSE_QR" in told.summary.linear_solver_reason
    assert told.summary.final_cost == pytest.approx(result.summary.final_cost, rel=1e-9)


@ceres_only
def test_rows_tell_what_the_step_did(adjust, perturbed):
    iterative = LinearSolverOptions(type="iterative_schur", forcing_tolerance=1e-3)
    rows = adjust(perturbed, options=BundleOptions(linear_solver=iterative)).summary.iterations
    steps = rows[1:]
    assert np.all(steps["step_is_valid"])
    assert np.all(steps["linear_solver_iterations"] > 1)
    assert np.all(steps["step_norm"] > 0.0)
    assert np.all(steps["linear_solver_time_s"] > 0.0)
    assert np.all(rows["gradient_max_norm"] > 0.0)
    assert rows["gradient_max_norm"][-1] < 1e-2 * rows["gradient_max_norm"][0]
    assert np.all((steps["gain_ratio"] > 0.0) & (steps["gain_ratio"] < 1.5))
    direct = adjust(perturbed).summary
    assert set(direct.iterations["linear_solver_iterations"][1:]) == {1}
    assert direct.num_threads == 1
    assert direct.residual_time_s > 0.0
    assert direct.jacobian_time_s > 0.0


def test_linearizing_without_a_free_block_gives_no_columns(perturbed):
    config = BundleConfig(
        constant_cameras=range(4), constant_intrinsics=range(4), constant_points=range(20)
    )
    linearization = raylign.bundle.linearize(perturbed, config=config)
    assert linearization.num_columns == 0
    assert linearization.row_starts.tolist() == [0] * 161
    assert linearization.cost == pytest.approx(oracle.cost(perturbed), rel=1e-12)


# --- nothing a user passes may end the process ----------------------------------------------------


@pytest.mark.parametrize("scale", [1e-170, 1e-101, 1e101, 1e160])
def test_scales_outside_the_range_of_double_are_refused(scale):
    with pytest.raises(raylign.OptionsError, match=r"Loss\.scale"):
        Loss(type=LossType.CAUCHY, scale=scale)


@pytest.mark.parametrize("loss_type", list(LossType), ids=lambda t: t.name)
@pytest.mark.parametrize("scale", [1e-100, 1e100])
def test_extreme_scales_end_well(adjust, perturbed, loss_type, scale):
    summary = adjust(
        perturbed, options=BundleOptions(loss=Loss(type=loss_type, scale=scale))
    ).summary
    assert np.isfinite(summary.final_cost)
    assert summary.final_cost <= summary.initial_cost


@ceres_only
def test_a_dense_matrix_that_ceres_cannot_index_is_refused(adjust):
    problem = raylign.synthetic.bal(num_cameras=6000, num_points=24000).problem
    options = BundleOptions(linear_solver=LinearSolverOptions(type="dense_schur"))
    with pytest.raises(raylign.OptionsError, match="dense_schur would allocate"):
        adjust(problem, options=options)


def test_linearizing_where_the_jacobian_overflows_is_an_error(adjust):
    problem = raylign.BalProblem(
        np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e300, 0.0, 0.0]]),
        np.array([[0.0, 0.0, -1e-10]]),
        np.zeros(1, np.int32),
        np.zeros(1, np.int32),
        np.zeros((1, 2)),
    )
    with pytest.raises(raylign.Error, match="not finite"):
        raylign.bundle.linearize(problem)
    assert adjust(problem).summary.termination is Termination.FAILURE


@ceres_only
def test_a_failure_after_good_steps_keeps_them(adjust, perturbed):
    """One camera alone, f and k1 held: conjugate gradients break down at the end."""
    problem = subproblem(perturbed, perturbed.camera_index == 0)
    held = [ConstantCoordinate(kind="intrinsics", coordinate=c) for c in ("f", "k1")]
    options = BundleOptions(
        point_parametrization="inverse_depth",
        linear_solver=LinearSolverOptions(type="iterative_schur"),
    )
    result = adjust(problem, config=BundleConfig(constant_coordinates=held), options=options)
    assert result.summary.num_accepted > 0
    assert result.summary.is_usable()
    assert result.summary.final_cost < result.summary.initial_cost
    assert oracle.cost(result.problem) == pytest.approx(
        result.summary.final_cost, rel=1e-6, abs=1e-12
    )


def test_overlapping_solves_put_the_process_settings_back(adjust, perturbed):
    openblas = ctypes.CDLL("libopenblas.so.0")  # the one that _core has loaded
    before = openblas.openblas_get_num_threads()
    threads = [threading.Thread(target=adjust, args=(perturbed,)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert openblas.openblas_get_num_threads() == before
    inside = []
    adjust(perturbed, callback=lambda it: inside.append(openblas.openblas_get_num_threads()))
    assert set(inside) == {1}


@pytest.mark.parametrize("backend", [Backend.NATIVE])
def test_native_rows_tell_what_the_step_did(adjust, perturbed):
    summary = adjust(perturbed).summary
    rows, steps = summary.iterations, summary.iterations[1:]
    assert np.all(steps["step_is_valid"])
    assert set(steps["linear_solver_iterations"]) == {1}
    assert np.all(steps["step_norm"] > 0.0)
    assert np.all(steps["linear_solver_time_s"] > 0.0)
    assert rows["gradient_max_norm"][-1] < 1e-2 * rows["gradient_max_norm"][0]
    assert np.all((steps["gain_ratio"] > 0.0) & (steps["gain_ratio"] < 1.5))
    assert summary.residual_time_s > 0.0
    assert summary.jacobian_time_s > 0.0


@ceres_only
def test_the_solver_is_silent_when_steps_fail(adjust, tiny_problem, capfd):
    rng = np.random.default_rng(1)
    tiny_problem.points[:] += rng.normal(0.0, 3.0, tiny_problem.points.shape)
    for solver in ("dense_schur", "sparse_schur", "iterative_schur"):
        options = BundleOptions(linear_solver=LinearSolverOptions(type=solver))
        adjust(tiny_problem, options=options)
    assert capfd.readouterr() == ("", "")


def test_text_stands_for_enumerators_and_losses():
    options = BundleOptions(pose_parametrization="quaternion", loss="cauchy:2.5")
    assert options.pose_parametrization is PoseParametrization.QUATERNION
    assert options.loss == Loss(type=LossType.CAUCHY, scale=2.5)
    with pytest.raises(
        raylign.OptionsError, match="one of se3, quaternion, angle_axis, got 'euler'"
    ):
        BundleOptions(pose_parametrization="euler")
    with pytest.raises(raylign.OptionsError, match=r"max_num_iterations must be like 50, got 2\.5"):
        LmOptions(max_num_iterations=2.5)
