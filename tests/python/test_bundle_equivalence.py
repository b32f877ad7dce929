"""The parametrisations describe one problem: same cost, gradients, steps after mapping."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

import oracle
import raylign
from raylign import geometry
from raylign.bundle import (
    BundleConfig,
    BundleOptions,
    Gauge,
    LinearSolverOptions,
    LinearSolverType,
    LmOptions,
    PointParametrization,
    PoseParametrization,
    adjust,
    linearize,
)

NUM_CAMERAS, NUM_POINTS = 4, 20


@pytest.fixture
def near(tiny_problem):
    """A start from which every parametrisation finds the one good optimum."""
    rng = np.random.default_rng(11)
    tiny_problem.points[:] += rng.normal(0.0, 0.02, tiny_problem.points.shape)
    tiny_problem.cameras[:, :6] += rng.normal(0.0, 0.02, (NUM_CAMERAS, 6))
    return tiny_problem


@pytest.fixture
def perturbed(near):
    """The same with one camera turned by almost π: nothing linear about it."""
    near.cameras[2, :3] *= (np.pi - 1e-4) / np.linalg.norm(near.cameras[2, :3])
    return near


def options_of(pose, point=PointParametrization.XYZ):
    return BundleOptions(pose_parametrization=pose, point_parametrization=point)


def rotation_and_translation_step(problem, camera, pose):
    """6x6 matrix from the user's tangent to (ω, dt): R ← Exp(ω) R, t ← t + dt, to first order."""
    omega, t = problem.cameras[camera, :3], problem.cameras[camera, 3:6]
    zero, eye = np.zeros((3, 3)), np.eye(3)
    if pose is PoseParametrization.SE3:
        return np.block([[zero, eye], [eye, -geometry.so3_hat(t)]])
    if pose is PoseParametrization.QUATERNION:
        return np.block([[zero, eye], [eye, zero]])
    return np.block([[geometry.so3_left_jacobian(omega), zero], [zero, eye]])


def common_step(problem, pose):
    """n x n block-diagonal map from the user's tangent of the whole problem to a common one."""
    n = 9 * NUM_CAMERAS + 3 * NUM_POINTS
    T = np.eye(n)
    for c in range(NUM_CAMERAS):
        T[9 * c : 9 * c + 6, 9 * c : 9 * c + 6] = rotation_and_translation_step(problem, c, pose)
    return T


def dense_jacobian(linearization):
    shape = (len(linearization.residuals), linearization.num_columns)
    arrays = (linearization.values, linearization.columns, linearization.row_starts)
    return csr_matrix(arrays, shape=shape).toarray()


def relative_difference(a, b):
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", list(PointParametrization), ids=lambda p: p.name)
def test_start_costs_are_equal(perturbed, pose, point):
    cost = linearize(perturbed, options=options_of(pose, point)).cost
    assert cost == pytest.approx(oracle.cost(perturbed), rel=1e-12)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", list(PointParametrization), ids=lambda p: p.name)
def test_gradient_is_that_of_the_weighted_residuals(perturbed, pose, point):
    linearization = linearize(perturbed, options=options_of(pose, point))
    expected = dense_jacobian(linearization).T @ linearization.residuals
    assert relative_difference(linearization.gradient, expected) < 1e-12
    np.testing.assert_allclose(
        linearization.residuals.reshape(-1, 2), oracle.residuals(perturbed), atol=1e-9
    )


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
def test_jacobian_equals_numeric_differences_of_the_independent_evaluator(perturbed, pose):
    J = dense_jacobian(linearize(perturbed, options=options_of(pose)))
    J_common = J @ np.linalg.inv(common_step(perturbed, pose))

    def moved(column, h):
        problem = perturbed.copy()
        if column >= 9 * NUM_CAMERAS:
            point, axis = divmod(column - 9 * NUM_CAMERAS, 3)
            problem.points[point, axis] += h
            return oracle.residuals(problem).ravel()
        camera, k = divmod(column, 9)
        if k < 3:
            step = geometry.so3_exp(h * np.eye(3)[k])
            R = step @ oracle.rotation_matrices(problem.cameras[:, :3])[camera]
            problem.cameras[camera, :3] = geometry.so3_log(R)
        else:
            problem.cameras[camera, k] += h
        return oracle.residuals(problem).ravel()

    for column in range(J.shape[1]):
        h = 1e-3 if column % 9 == 6 and column < 9 * NUM_CAMERAS else 1e-6
        numeric = (moved(column, h) - moved(column, -h)) / (2.0 * h)
        scale = max(1.0, np.max(np.abs(numeric)))
        assert np.max(np.abs(J_common[:, column] - numeric)) < 1e-6 * scale


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
def test_gradients_are_related_by_the_tangent_map(perturbed, pose):
    """g_user = Tᵀ g."""
    reference = PoseParametrization.SE3
    g = linearize(perturbed, options=options_of(reference)).gradient
    g_common = np.linalg.solve(common_step(perturbed, reference).T, g)
    g_user = linearize(perturbed, options=options_of(pose)).gradient
    assert relative_difference(common_step(perturbed, pose).T @ g_common, g_user) < 1e-9


def gauss_newton_step(problem, pose):
    """Undamped step with the gauge fixed by two cameras, and J times it."""
    config = BundleConfig(gauge=Gauge.TWO_CAMERAS)
    linearization = linearize(problem, config=config, options=options_of(pose))
    J = dense_jacobian(linearization)
    scale = np.linalg.norm(J, axis=0)
    delta = np.linalg.lstsq(J / scale, -linearization.residuals, rcond=None)[0] / scale
    return delta, J @ delta


def test_undamped_gauss_newton_steps_are_equal(perturbed):
    """The step as every residual sees it, J δ, and as every point and intrinsic moves."""
    steps = {pose: gauss_newton_step(perturbed, pose) for pose in PoseParametrization}
    reference_delta, reference_prediction = steps[PoseParametrization.SE3]
    for delta, prediction in steps.values():
        assert relative_difference(prediction, reference_prediction) < 1e-8
        assert (
            relative_difference(delta[-3 * NUM_POINTS :], reference_delta[-3 * NUM_POINTS :]) < 1e-8
        )


def test_mapped_pose_steps_are_equal(perturbed):
    """Steps of cameras 2 and 3, the others held, mapped to (ω, dt)."""
    mapped = {}
    for pose in PoseParametrization:
        config = BundleConfig(constant_cameras=[0, 1])
        linearization = linearize(perturbed, config=config, options=options_of(pose))
        J = dense_jacobian(linearization)
        scale = np.linalg.norm(J, axis=0)
        delta = np.linalg.lstsq(J / scale, -linearization.residuals, rcond=None)[0] / scale
        step = []
        offset = 2 * 3  # cameras 0 and 1 have intrinsics only
        for c in (2, 3):
            step.append(
                rotation_and_translation_step(perturbed, c, pose) @ delta[offset : offset + 6]
            )
            offset += 9
        mapped[pose] = np.concatenate(step)
    for step in mapped.values():
        assert relative_difference(step, mapped[PoseParametrization.SE3]) < 1e-8


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", list(PointParametrization), ids=lambda p: p.name)
def test_all_parametrisations_reach_the_same_optimum(near, pose, point):
    lm = LmOptions(
        max_num_iterations=200,
        function_tolerance=1e-15,
        gradient_tolerance=1e-15,
        parameter_tolerance=1e-15,
    )
    reference = adjust(near, options=BundleOptions(lm=lm)).summary.final_cost
    options = options_of(pose, point).replace(lm=lm)
    assert adjust(near, options=options).summary.final_cost == pytest.approx(reference, rel=1e-9)


def permuted(problem, seed):
    """Cameras, points and observations in another order."""
    rng = np.random.default_rng(seed)
    c, p, n = (
        rng.permutation(problem.num_cameras),
        rng.permutation(problem.num_points),
        rng.permutation(problem.num_observations),
    )
    return raylign.BalProblem(
        np.ascontiguousarray(problem.cameras[np.argsort(c)]),
        np.ascontiguousarray(problem.points[np.argsort(p)]),
        c[problem.camera_index[n]].astype(np.int32),
        p[problem.point_index[n]].astype(np.int32),
        np.ascontiguousarray(problem.observations[n]),
    )


TIGHT = LmOptions(
    max_num_iterations=300,
    function_tolerance=1e-15,
    gradient_tolerance=1e-15,
    parameter_tolerance=1e-15,
)


def test_order_does_not_matter(near):
    options = BundleOptions(lm=TIGHT)
    shuffled = permuted(near, 5)
    assert oracle.cost(shuffled) == pytest.approx(oracle.cost(near), rel=1e-12)
    a = adjust(near, options=options).summary.final_cost
    b = adjust(shuffled, options=options).summary.final_cost
    assert b == pytest.approx(a, rel=1e-10)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", list(PointParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("scale", [1e-3, 1e3, 1e9])
def test_the_unit_of_length_does_not_matter(near, pose, point, scale):
    scaled = near.transformed(np.diag([scale, scale, scale, 1.0]))
    options = options_of(pose, point).replace(lm=TIGHT)
    a = adjust(near, options=options)
    b = adjust(scaled, options=options)
    assert b.summary.final_cost == pytest.approx(a.summary.final_cost, rel=1e-6)
    assert oracle.cost(b.problem) == pytest.approx(b.summary.final_cost, rel=1e-9)


def test_a_similarity_of_the_world_does_not_matter(near):
    S = geometry.sim3_exp(np.array([3.0, -2.0, 1.0, 0.4, 0.5, -0.6, 0.7]))
    moved = near.transformed(S)
    assert oracle.cost(moved) == pytest.approx(oracle.cost(near), rel=1e-10)
    options = BundleOptions(lm=TIGHT)
    a = adjust(near, options=options).summary.final_cost
    b = adjust(moved, options=options).summary.final_cost
    assert b == pytest.approx(a, rel=1e-10)


def test_the_unit_of_a_pixel_does_not_matter(near):
    scaled = near.copy()
    scaled.observations[:] *= 0.01
    scaled.cameras[:, 6] *= 0.01
    options = BundleOptions(lm=TIGHT)
    a = adjust(near, options=options).summary
    b = adjust(scaled, options=options).summary
    assert b.initial_cost == pytest.approx(1e-4 * a.initial_cost, rel=1e-12)
    assert b.final_cost == pytest.approx(1e-4 * a.final_cost, rel=1e-9)


# --- known truth ---------------------------------------------------------------------------------


def centers_and_points(problem):
    return np.concatenate([problem.camera_centers(), problem.points])


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
def test_without_noise_the_truth_comes_back(pose):
    scene = raylign.synthetic.bal(
        kind="orbit", num_cameras=12, num_points=300, pixel_noise=0.0, seed=2
    )
    options = BundleOptions(pose_parametrization=pose, lm=TIGHT)
    refined = adjust(scene.problem, options=options).problem
    estimate, truth = centers_and_points(refined), centers_and_points(scene.truth)
    S = geometry.umeyama(estimate, truth, with_scale=True)
    aligned = estimate @ S[:3, :3].T + S[:3, 3]
    extent = np.linalg.norm(truth - truth.mean(axis=0), axis=1).max()
    assert np.max(np.linalg.norm(aligned - truth, axis=1)) < 1e-8 * extent


def test_with_one_pixel_of_noise_chi2_per_degree_of_freedom_is_one():
    scene = raylign.synthetic.bal(
        num_cameras=30, num_points=3000, pixel_noise=1.0, outlier_fraction=0.0, seed=3
    )
    summary = adjust(
        scene.problem, options=BundleOptions(lm=TIGHT.replace(max_num_iterations=60))
    ).summary
    freedoms = summary.num_residuals - (summary.num_effective_parameters - 7)
    assert 2.0 * summary.final_cost / freedoms == pytest.approx(1.0, abs=0.03)


# --- real data -----------------------------------------------------------------------------------


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "start", "end"),
    [
        ("problem-49-7776-pre.txt", 8.509125e5, 13344.33),
        ("problem-21-11315-pre.txt", 4.413239e6, 30378.6),
    ],
)
def test_real_problems_reach_the_known_cost(shared_data, name, start, end):
    problem = raylign.io.read_bal(shared_data / "bal" / name)
    assert oracle.cost(problem) == pytest.approx(start, rel=1e-6)
    result = adjust(problem)
    assert result.summary.initial_cost == pytest.approx(oracle.cost(problem), rel=1e-12)
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)
    assert result.summary.final_cost <= end * (1.0 + 1e-4)


@pytest.mark.data
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "end"),
    [("problem-49-7776-pre.txt", 13344.24), ("problem-21-11315-pre.txt", 30378.5)],
)
def test_real_problems_at_tight_tolerances(shared_data, name, end):
    problem = raylign.io.read_bal(shared_data / "bal" / name)
    lm = LmOptions(
        max_num_iterations=200,
        function_tolerance=1e-12,
        gradient_tolerance=1e-14,
        parameter_tolerance=1e-14,
    )
    solver = LinearSolverOptions(type=LinearSolverType.DENSE_SCHUR)
    result = adjust(problem, options=BundleOptions(lm=lm, linear_solver=solver))
    assert result.summary.final_cost <= end * (1.0 + 1e-5)
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)
