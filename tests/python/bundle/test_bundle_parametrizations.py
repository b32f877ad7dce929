"""raylign.bundle.adjust: every parametrisation keeps every promise."""

import numpy as np
import pytest

import oracle
import raylign
from bundle_cases import POINTS, TIGHT, ceres_only, subproblem
from raylign.bundle import (
    BundleConfig,
    BundleOptions,
    Gauge,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    PointParametrization,
    PoseParametrization,
)
from raylign.robust import Loss, LossType


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
