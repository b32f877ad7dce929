"""raylign.bundle.adjust: nothing a user passes may end the process."""

import ctypes
import threading

import numpy as np
import pytest

import oracle
import raylign
from bundle_cases import ceres_only, subproblem
from raylign.bundle import (
    Backend,
    BundleConfig,
    BundleOptions,
    ConstantCoordinate,
    LinearSolverOptions,
    LmOptions,
    PoseParametrization,
    Termination,
)
from raylign.robust import Loss, LossType


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
