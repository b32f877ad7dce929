"""raylign.scene.BundleProblem and its adjustment: pinhole and Brown-Conrady beside BAL."""

import copy
import pickle

import numpy as np
import pytest

import raylign
from raylign import bundle, camera, geometry
from raylign.bundle import (
    Backend,
    BundleConfig,
    BundleOptions,
    ConstantCoordinate,
    Gauge,
    LmOptions,
    ParameterKind,
    PointParametrization,
    PoseParametrization,
    Termination,
)
from raylign.scene import BalProblem, BundleProblem, CameraModel, param_names

MODELS = list(CameraModel)
CAMERAS = {
    CameraModel.BAL: camera.BalCamera,
    CameraModel.PINHOLE: camera.PinholeCamera,
    CameraModel.RADTAN: camera.RadtanCamera,
}
PARAMS = {
    CameraModel.BAL: [500.0, -1e-2, 1e-3],
    CameraModel.PINHOLE: [500.0, 480.0, 320.0, 240.0],
    CameraModel.RADTAN: [500.0, 480.0, 320.0, 240.0, -0.1, 0.02, 1e-3, -5e-4, 0.01],
}
TIGHT = LmOptions(
    max_num_iterations=100,
    function_tolerance=1e-15,
    gradient_tolerance=1e-12,
    parameter_tolerance=1e-14,
)


def make_truth(model: CameraModel, *, sigma: float = 0.0) -> BundleProblem:
    """6 cameras on an arc around 60 points, every camera sees every point."""
    rng = np.random.default_rng(11)
    num_cameras, num_points = 6, 60
    points = rng.normal(0.0, 0.7, (num_points, 3))
    xi = np.zeros((num_cameras, 6))
    xi[:, 4] = np.linspace(-0.6, 0.6, num_cameras)
    xi[:, 3] = 0.3 * (-1.0) ** np.arange(num_cameras)  # parallel axes would leave fx / fy free
    T_cw = geometry.se3_exp(xi)
    view_z = -6.0 if model is CameraModel.BAL else 6.0
    T_cw[:, :3, 3] = rng.normal([0.0, 0.0, view_z], 0.1, (num_cameras, 3))
    intrinsics = np.tile(PARAMS[model], (num_cameras, 1))
    intrinsics[:, 0] += np.arange(num_cameras)
    camera_index, point_index = np.divmod(np.arange(num_cameras * num_points), num_points)
    observations = np.empty((len(camera_index), 2))
    for c in range(num_cameras):
        p_c = points @ T_cw[c, :3, :3].T + T_cw[c, :3, 3]
        uv, valid = CAMERAS[model](*intrinsics[c]).project(p_c)
        assert valid.all()
        observations[camera_index == c] = uv
    observations += rng.normal(0.0, sigma, observations.shape) if sigma > 0.0 else 0.0
    return BundleProblem(
        model,
        T_cw,
        intrinsics,
        points,
        camera_index.astype(np.int32),
        point_index.astype(np.int32),
        observations,
    )


def perturb(truth: BundleProblem) -> BundleProblem:
    rng = np.random.default_rng(5)
    problem = truth.copy()
    problem.points[:] += rng.normal(0.0, 0.05, problem.points.shape)
    problem.T_cw[:] = geometry.se3_exp(rng.normal(0.0, 0.01, (truth.num_cameras, 6))) @ truth.T_cw
    problem.intrinsics[:, 0] *= 1.01
    return problem


def held_principal_point(model: CameraModel) -> list[ConstantCoordinate]:
    """Six zero-skew cameras with everything else free are a reconstruction up to a projectivity."""
    return [
        ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate=name)
        for name in ("cx", "cy")
        if name in param_names(model)
    ]


@pytest.fixture(params=MODELS, ids=lambda m: m.name)
def model(request):
    return request.param


@pytest.fixture
def truth(model):
    return make_truth(model)


@pytest.fixture
def noisy(model):
    return perturb(make_truth(model, sigma=0.5))


# --- the class -----------------------------------------------------------------------------------


def test_residuals_equal_the_cameras_own_projection(noisy, model):
    c, p = noisy.camera_index, noisy.point_index
    p_c = np.einsum("nij,nj->ni", noisy.T_cw[c, :3, :3], noisy.points[p]) + noisy.T_cw[c, :3, 3]
    expected = np.empty((noisy.num_observations, 2))
    for i in range(noisy.num_cameras):
        expected[c == i] = CAMERAS[model](*noisy.intrinsics[i]).project(p_c[c == i])[0]
    np.testing.assert_allclose(noisy.residuals(), expected - noisy.observations, atol=1e-9)
    assert noisy.cost() == pytest.approx(0.5 * np.sum(noisy.residuals() ** 2), rel=1e-13)
    view_z = -1.0 if model is CameraModel.BAL else 1.0
    np.testing.assert_allclose(noisy.depths(), view_z * p_c[:, 2], rtol=1e-12)
    assert param_names(model) == list(CAMERAS[model].__fields__)


def test_value_semantics(noisy):
    for same in (noisy.copy(), copy.deepcopy(noisy), pickle.loads(pickle.dumps(noisy))):
        assert same == noisy
        same.T_cw[0, 0, 3] += 1.0
        assert same != noisy
    assert noisy.replace(points=noisy.points + 1.0).points[0, 0] == noisy.points[0, 0] + 1.0
    assert noisy.camera_model.name.lower() in repr(noisy)


def bad_arguments():
    good = make_truth(CameraModel.RADTAN).to_dict()
    tilted = good["T_cw"].copy()
    tilted[2, 0, 0] += 1e-3
    last = good["camera_index"].copy()
    last[-1] = 6
    return [
        ("T_cw", good["T_cw"][:, :3], "shape"),
        ("T_cw", good["T_cw"].astype(np.float32), "float64"),
        ("T_cw", good["T_cw"][:-1], "T_cw"),
        ("T_cw", tilted, r"T_cw\[2\] is not a rigid"),
        ("T_cw", np.full_like(good["T_cw"], np.nan), r"T_cw\[0\] is not a rigid"),
        ("intrinsics", good["intrinsics"][:, :4].copy(), "intrinsics"),
        ("intrinsics", np.asfortranarray(good["intrinsics"]), "C-ordered"),
        ("points", good["points"].tolist(), "list"),
        ("camera_index", last, "not in"),
        ("camera_index", good["camera_index"].astype(np.int64), "int32"),
        ("point_index", good["point_index"][1:], "point_index"),
        ("observations", good["observations"][:, :1], "observations"),
        ("colors", np.zeros((3, 3), np.uint8), "colors"),
    ]


@pytest.mark.parametrize(("name", "value", "message"), bad_arguments())
def test_hostile_arrays_are_shape_errors(name, value, message):
    with pytest.raises(raylign.ShapeError, match=message):
        make_truth(CameraModel.RADTAN).replace(**{name: value})


def test_views_that_were_broken_are_refused_by_adjust(noisy):
    noisy.T_cw[3, :3, :3] *= 2.0
    with pytest.raises(raylign.ShapeError, match=r"T_cw\[3\]"):
        bundle.adjust(noisy)


def test_a_bal_problem_and_its_bundle_problem_have_one_solution(tiny_problem):
    tiny_problem.points[:] += np.random.default_rng(0).normal(0.0, 0.05, (20, 3))
    expected = bundle.adjust(tiny_problem, options=BundleOptions(lm=TIGHT)).summary.final_cost
    for camera_model in (CameraModel.BAL, CameraModel.RADTAN):
        problem = BundleProblem.from_bal(tiny_problem, camera_model=camera_model)
        assert problem.to_bal().cost() == pytest.approx(tiny_problem.cost(), rel=1e-12)
        held = [
            ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate=name)
            for name in param_names(camera_model)
        ]
        if camera_model is CameraModel.BAL:
            result = bundle.adjust(problem, options=BundleOptions(lm=TIGHT))
            assert result.summary.final_cost == pytest.approx(expected, rel=1e-9)
            assert isinstance(result.problem.to_bal(), BalProblem)
        else:  # f = fx = fy cannot be tied yet: compare where f, k1, k2 are held
            config = BundleConfig(constant_coordinates=held)
            ours = bundle.adjust(problem, config=config, options=BundleOptions(lm=TIGHT))
            bal = bundle.adjust(
                tiny_problem,
                config=BundleConfig(constant_intrinsics=range(4)),
                options=BundleOptions(lm=TIGHT),
            )
            assert ours.summary.final_cost == pytest.approx(bal.summary.final_cost, rel=1e-9)


# --- adjustment ----------------------------------------------------------------------------------


def test_the_truth_is_recovered_from_perfect_pixels(truth, model):
    start = perturb(truth)
    result = bundle.adjust(
        start,
        config=BundleConfig(
            gauge=Gauge.TWO_CAMERAS, constant_coordinates=held_principal_point(model)
        ),
        options=BundleOptions(lm=TIGHT),
    )
    assert result.summary.is_usable()
    assert result.problem.cost() < 1e-16
    centers, true = result.problem.camera_centers(), truth.camera_centers()
    S = geometry.umeyama(centers, true)
    np.testing.assert_allclose(centers @ S[:3, :3].T + S[:3, 3], true, atol=1e-6)
    np.testing.assert_allclose(result.problem.intrinsics, truth.intrinsics, rtol=1e-5, atol=1e-5)
    assert start == perturb(truth)  # the input is not modified


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", list(PointParametrization), ids=lambda p: p.name)
def test_every_parametrisation_reaches_the_same_cost(noisy, model, pose, point):
    config = BundleConfig(constant_coordinates=held_principal_point(model))
    options = BundleOptions(pose_parametrization=pose, point_parametrization=point, lm=TIGHT)
    result = bundle.adjust(noisy, config=config, options=options)
    reference = bundle.adjust(noisy, config=config, options=BundleOptions(lm=TIGHT))
    assert result.summary.final_cost == pytest.approx(reference.summary.final_cost, rel=1e-8)
    assert result.problem.cost() == pytest.approx(result.summary.final_cost, rel=1e-10)


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
def test_held_numbers_come_back_bit_by_bit(noisy, model, pose):
    name = param_names(model)[1]
    held = [
        ConstantCoordinate(kind=ParameterKind.POSE, index=0, coordinate="rotation"),
        ConstantCoordinate(kind=ParameterKind.POSE, index=1, coordinate="tx"),
        ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate=name),
        ConstantCoordinate(kind=ParameterKind.POINT, index=5, coordinate="y"),
    ]
    config = BundleConfig(
        constant_cameras=[3],
        constant_intrinsics=[2],
        constant_points=[7],
        constant_coordinates=held,
    )
    result = bundle.adjust(noisy, config=config, options=BundleOptions(pose_parametrization=pose))
    assert result.summary.final_cost < result.summary.initial_cost
    changed = result.problem.T_cw[:, :3] != noisy.T_cw[:, :3]
    assert not changed[3].any()
    assert not changed[0, :, :3].any()
    assert changed[0, :, 3].all()
    assert not changed[1, 0, 3]
    assert changed[1, 1:, 3].all()
    assert changed[1, :, :3].any()
    changed = result.problem.intrinsics != noisy.intrinsics
    assert not changed[2].any()
    assert not changed[:, 1].any()
    assert changed[[0, 1, 3], 0].all()
    changed = result.problem.points != noisy.points
    assert not changed[7].any()
    assert not changed[5, 1]
    assert changed[5, [0, 2]].all()


def test_same_input_same_bits(noisy):
    first, second = bundle.adjust(noisy), bundle.adjust(noisy)
    assert first.problem == second.problem
    assert first.problem != noisy


def test_nothing_to_do_changes_nothing(noisy, model):
    everything = BundleConfig(
        constant_cameras=range(6), constant_intrinsics=range(6), constant_points=range(60)
    )
    assert bundle.adjust(noisy, config=everything).problem == noisy
    zero = BundleOptions(lm=LmOptions(max_num_iterations=0))
    assert bundle.adjust(noisy, options=zero).problem == noisy
    empty = BundleProblem(
        model,
        np.zeros((0, 4, 4)),
        np.zeros((0, len(PARAMS[model]))),
        np.zeros((0, 3)),
        np.zeros(0, np.int32),
        np.zeros(0, np.int32),
        np.zeros((0, 2)),
    )
    assert bundle.adjust(empty).problem == empty


def test_jacobian_is_the_derivative_of_the_residuals(noisy, model):
    config = BundleConfig(constant_points=range(60), constant_cameras=range(6))
    linear = bundle.linearize(noisy, config=config)
    m = len(PARAMS[model])
    J = np.zeros((2 * noisy.num_observations, linear.num_columns))
    for row in range(len(J)):
        span = slice(linear.row_starts[row], linear.row_starts[row + 1])
        J[row, linear.columns[span]] = linear.values[span]
    assert linear.num_columns == 6 * m
    for column in range(6 * m):
        h = 1e-4 if column % m < (1 if model is CameraModel.BAL else 4) else 1e-6
        ends = []
        for sign in (1.0, -1.0):
            moved = noisy.copy()
            moved.intrinsics[column // m, column % m] += sign * h
            ends.append(moved.residuals().ravel())
        numeric = (ends[0] - ends[1]) / (2.0 * h)
        np.testing.assert_allclose(J[:, column], numeric, rtol=1e-5, atol=1e-5)


# --- where a camera sees nothing ------------------------------------------------------------------


@pytest.fixture
def behind(model):
    """The first point of camera 0 lies behind that camera at the start."""
    problem = perturb(make_truth(model, sigma=0.5))
    view = -1.0 if model is CameraModel.BAL else 1.0
    T_wc = np.linalg.inv(problem.T_cw[0])
    problem.points[0] = (T_wc @ [0.1, 0.2, -3.0 * view, 1.0])[:3]
    return problem


def test_a_start_behind_the_camera_has_a_clear_answer(behind, model):
    assert behind.statistics().num_behind_camera >= 1
    result = bundle.adjust(behind)
    if model is CameraModel.BAL:  # no cheirality test in that cost
        assert result.summary.is_usable()
        assert np.isfinite(result.summary.final_cost)
        return
    assert result.summary.termination is Termination.FAILURE
    assert "observation 0 (camera 0, point 0)" in result.summary.message
    assert "depth is -" in result.summary.message
    assert result.problem == behind


def test_dropping_the_observations_without_a_residual_goes_on(behind):
    seen = np.isfinite(behind.residuals()).all(axis=1)
    kept = behind.replace(
        camera_index=behind.camera_index[seen],
        point_index=behind.point_index[seen],
        observations=behind.observations[seen],
    )
    result = bundle.adjust(kept)
    assert result.summary.is_usable()
    assert result.summary.final_cost < result.summary.initial_cost


@pytest.mark.parametrize("model", [CameraModel.PINHOLE, CameraModel.RADTAN], ids=lambda m: m.name)
def test_no_step_takes_a_point_behind_its_camera(model):
    """Noise so large that least squares would like to: every accepted state stays in front."""
    problem = make_truth(model, sigma=60.0)
    problem.points[:, 2] -= 4.0  # just in front of the cameras
    keep = (problem.depths() > 0.1) & np.isfinite(problem.residuals()).all(axis=1)
    problem = problem.replace(
        camera_index=problem.camera_index[keep],
        point_index=problem.point_index[keep],
        observations=problem.observations[keep],
    )
    result = bundle.adjust(problem)
    assert np.isfinite(result.summary.final_cost)
    assert result.problem.cost() == pytest.approx(result.summary.final_cost, rel=1e-10)
    assert result.problem.depths().min() > 0.0


# --- the native engine ---------------------------------------------------------------------------


def three_free(model: CameraModel) -> BundleConfig:
    """At most three free intrinsics: what the native engine moves."""
    free = {CameraModel.PINHOLE: ["fx", "fy"], CameraModel.RADTAN: ["fx", "fy", "k1"]}
    names = param_names(model)
    return BundleConfig(
        constant_coordinates=[
            ConstantCoordinate(kind=ParameterKind.INTRINSICS, coordinate=name)
            for name in names
            if name not in free.get(model, names)
        ]
    )


@pytest.mark.parametrize("pose", list(PoseParametrization), ids=lambda p: p.name)
@pytest.mark.parametrize("point", ["xyz", "homogeneous"])
def test_both_engines_walk_the_same_path(noisy, model, pose, point):
    options = BundleOptions(pose_parametrization=pose, point_parametrization=point, parity=True)
    ceres, native = (
        bundle.adjust(noisy, config=three_free(model), options=options.replace(backend=backend))
        for backend in (Backend.CERES, Backend.NATIVE)
    )
    costs = native.summary.iterations["cost"], ceres.summary.iterations["cost"]
    count = min(map(len, costs))
    assert count >= 3
    np.testing.assert_allclose(costs[0][:count], costs[1][:count], rtol=1e-8)
    assert native.summary.final_cost == pytest.approx(ceres.summary.final_cost, rel=1e-6)
    assert native.problem.cost() == pytest.approx(native.summary.final_cost, rel=1e-10)
    parameters = [s.num_effective_parameters for s in (native.summary, ceres.summary)]
    assert parameters[0] == parameters[1]


def test_native_holds_what_is_held_and_gives_the_same_bits(noisy, model):
    config = three_free(model).replace(
        constant_cameras=[3], constant_intrinsics=[2], constant_points=[7]
    )
    results = [
        bundle.adjust(
            noisy,
            config=config,
            options=BundleOptions(backend=Backend.NATIVE, lm=LmOptions(num_threads=threads)),
        )
        for threads in (1, 2, 4)
    ]
    assert results[0].problem == results[1].problem == results[2].problem
    refined = results[0].problem
    assert np.array_equal(refined.T_cw[3], noisy.T_cw[3])
    assert np.array_equal(refined.points[7], noisy.points[7])
    assert np.array_equal(refined.intrinsics[2], noisy.intrinsics[2])
    assert np.all(refined.intrinsics[[0, 1, 3], 0] != noisy.intrinsics[[0, 1, 3], 0])
    held = 2 if model is CameraModel.PINHOLE else 5
    if model is not CameraModel.BAL:
        assert np.array_equal(refined.intrinsics[:, held:], noisy.intrinsics[:, held:])


def test_native_recovers_the_truth_of_calibrated_cameras(truth):
    start = perturb(truth)
    start.intrinsics[:] = truth.intrinsics
    config = BundleConfig(gauge=Gauge.TWO_CAMERAS, constant_intrinsics=range(6))
    options = BundleOptions(backend=Backend.NATIVE, lm=TIGHT)
    result = bundle.adjust(start, config=config, options=options)
    assert result.problem.cost() < 1e-16
    centers, true = result.problem.camera_centers(), truth.camera_centers()
    S = geometry.umeyama(centers, true)
    np.testing.assert_allclose(centers @ S[:3, :3].T + S[:3, 3], true, atol=1e-8)


def test_native_refuses_a_start_behind_the_camera_in_the_same_words(behind, model):
    summaries = [
        bundle.adjust(
            behind, config=three_free(model), options=BundleOptions(backend=backend)
        ).summary
        for backend in (Backend.CERES, Backend.NATIVE)
    ]
    if model is CameraModel.BAL:
        assert all(s.is_usable() for s in summaries)
        return
    assert [s.termination for s in summaries] == [Termination.FAILURE] * 2
    assert summaries[0].message == summaries[1].message


@pytest.mark.parametrize("model", [CameraModel.PINHOLE, CameraModel.RADTAN], ids=lambda m: m.name)
def test_native_says_how_many_intrinsics_it_moves(noisy):
    with pytest.raises(raylign.OptionsError, match="at most 3 intrinsics"):
        bundle.adjust(noisy, options=BundleOptions(backend=Backend.NATIVE))
    summary = bundle.adjust(noisy).summary  # the default finds who can
    assert summary.backend == "ceres"
    assert "at most 3 intrinsics" in summary.backend_reason
