"""raylign.bundle.adjust: what is held comes back as it was; gauges."""

import numpy as np
import pytest

import oracle
import raylign
from bundle_cases import POINTS, TIGHT, ceres_only
from raylign.bundle import (
    BundleConfig,
    BundleOptions,
    ConstantCoordinate,
    Gauge,
    LinearSolverOptions,
    LinearSolverType,
    ParameterKind,
    PointParametrization,
    PoseParametrization,
    Preconditioner,
    Termination,
)


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
