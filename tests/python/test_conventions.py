"""One test for each line of docs/conventions.md (the rest of them stands in contracts/).

Expectations are literal numbers or written out with NumPy, never computed by the code under test.
"""

import enum
import importlib
import inspect
import math
import pkgutil
import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import raylign
from raylign import _core, bundle, camera, depth, geometry, image, io, synthetic, tracking
from raylign.bundle import BundleConfig, BundleOptions, Gauge, LmOptions, Termination, adjust
from raylign.robust import Loss, LossType
from raylign.scene import BalProblem

ROOT = Path(__file__).resolve().parents[2]
QUARTER_TURN_Z = np.array([0.0, 0.0, math.pi / 2])


def without_intrinsics_change(problem: BalProblem) -> BundleConfig:
    return BundleConfig(constant_intrinsics=list(range(problem.num_cameras)))


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.tobytes() == b.tobytes()


# --- frames and tangents -------------------------------------------------------------------------


def test_transform_ab_maps_b_to_a():
    """A body one unit along world x, turned by 90° about z: its own x axis points along world y."""
    T_wb = geometry.se3_exp(np.concatenate([np.zeros(3), QUARTER_TURN_Z]))
    T_wb[:3, 3] = [1.0, 0.0, 0.0]
    p_b = np.array([1.0, 0.0, 0.0])
    p_w = T_wb[:3, :3] @ p_b + T_wb[:3, 3]
    np.testing.assert_allclose(p_w, [1.0, 1.0, 0.0], atol=1e-15)
    T_bw = geometry.se3_inverse(T_wb)
    np.testing.assert_allclose(T_wb @ T_bw, np.eye(4), atol=1e-15)


def test_se3_tangent_is_translation_first():
    T = geometry.se3_exp(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]))
    np.testing.assert_array_equal(T[:3, 3], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(T[:3, :3], np.eye(3))


def test_sim3_tangent_ends_with_log_scale():
    S = geometry.sim3_exp(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, math.log(2.0)]))
    np.testing.assert_allclose(S, np.diag([2.0, 2.0, 2.0, 1.0]), rtol=1e-15)


def test_updates_are_left_perturbations(tiny_problem: BalProblem):
    """The pose columns of J are derivatives with respect to ξ in T ← exp(ξ) T, ξ = [υ; ω]."""
    J = dense_jacobian(tiny_problem)
    step = 1e-6
    T_cw = tiny_problem.T_cw()[1]
    for k in range(6):
        xi = np.zeros(6)
        xi[k] = step
        plus, minus = (
            residuals_with_pose(tiny_problem, 1, exp_se3(s * xi) @ T_cw) for s in (1, -1)
        )
        numeric = (plus - minus).ravel() / (2 * step)
        np.testing.assert_allclose(J[:, 9 + k], numeric, rtol=1e-5, atol=1e-4)


def dense_jacobian(problem: BalProblem) -> np.ndarray:
    linear = bundle.linearize(problem)
    J = np.zeros((2 * problem.num_observations, len(linear.gradient)))
    rows = np.repeat(np.arange(len(J)), np.diff(linear.row_starts))
    J[rows, linear.columns] = linear.values
    return J


def exp_se3(xi: np.ndarray) -> np.ndarray:
    """First-order exp([υ; ω]), enough for a difference quotient of 1e-6."""
    wx, wy, wz = xi[3:]
    T = np.eye(4)
    T[:3, :3] += np.array([[0.0, -wz, wy], [wz, 0.0, -wx], [-wy, wx, 0.0]])
    T[:3, 3] = xi[:3]
    return T


def residuals_with_pose(problem: BalProblem, index: int, T_cw: np.ndarray) -> np.ndarray:
    """Predicted − observed with camera `index` at T_cw, in NumPy from the rotation matrices."""
    poses = problem.T_cw()
    poses[index] = T_cw
    P = np.einsum("nij,nj->ni", poses[problem.camera_index], homogeneous(problem))[:, :3]
    f, k1, k2 = problem.cameras[problem.camera_index, 6:].T
    p = -P[:, :2] / P[:, 2:]
    r2 = np.sum(p**2, axis=1)
    return (f * (1 + k1 * r2 + k2 * r2**2))[:, None] * p - problem.observations


def homogeneous(problem: BalProblem) -> np.ndarray:
    X = problem.points[problem.point_index]
    return np.concatenate([X, np.ones((len(X), 1))], axis=1)


def test_quaternions_are_xyzw():
    q = geometry.quaternion_exp(QUARTER_TURN_Z)
    half = math.sqrt(0.5)
    np.testing.assert_allclose(q, [0.0, 0.0, half, half], rtol=1e-15)
    np.testing.assert_allclose(
        geometry.quaternion_to_matrix(q), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15
    )


def test_leading_axes_are_batches():
    xi = np.linspace(-1.0, 1.0, 2 * 3 * 6).reshape(2, 3, 6)
    T = geometry.se3_exp(xi)
    assert T.shape == (2, 3, 4, 4)
    assert T.dtype == np.float64
    np.testing.assert_array_equal(T[1, 2], geometry.se3_exp(xi[1, 2]))
    np.testing.assert_allclose(geometry.se3_log(T), xi, rtol=1e-12, atol=1e-14)


# --- cameras and pixels --------------------------------------------------------------------------


def test_pixels_are_column_row():
    """Right of the axis raises u, below it raises v; the principal point is where the axis hits."""
    pinhole = camera.PinholeCamera(fx=100.0, fy=200.0, cx=3.0, cy=5.0)
    points = np.array([[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, 0.1, 1.0]])
    uv = camera_pixels(pinhole, points)
    np.testing.assert_allclose(uv, [[3.0, 5.0], [13.0, 5.0], [3.0, 25.0]], rtol=1e-15)


def camera_pixels(model: Any, points: np.ndarray) -> np.ndarray:
    """Pixels of points that are all in view."""
    return model.project(points)[0]


def test_cameras_look_along_plus_z():
    pinhole = camera.PinholeCamera(fx=100.0, fy=100.0, cx=0.0, cy=0.0)
    valid = pinhole.project(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))[1]
    assert valid.tolist() == [True, False]


def test_bal_camera_looks_along_minus_z(tiny_problem: BalProblem):
    """(1, 2, −10) with f = 50, k1 = 0.1, k2 = 0.01 by hand."""
    one = BalProblem(
        np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 50.0, 0.1, 0.01]]),
        np.array([[1.0, 2.0, -10.0]]),
        np.zeros(1, np.int32),
        np.zeros(1, np.int32),
        np.zeros((1, 2)),
    )
    r2 = 0.1**2 + 0.2**2
    scale = 50.0 * (1.0 + 0.1 * r2 + 0.01 * r2 * r2)
    np.testing.assert_allclose(one.residuals(), [[scale * 0.1, scale * 0.2]], rtol=1e-14)
    np.testing.assert_array_equal(one.depths(), [10.0])


def test_grey_is_0_to_255():
    assert image.to_grey(np.array([[0, 255]], np.uint8)).tolist() == [[0.0, 255.0]]
    assert image.to_grey(np.array([[257, 65535]], np.uint16)).tolist() == [[1.0, 255.0]]
    assert image.to_grey(np.array([[-0.5, 300.0]], np.float32)).tolist() == [[-0.5, 300.0]]
    red = np.array([[[100, 0, 0]]], np.uint8)
    np.testing.assert_allclose(image.to_grey(red), 29.9, rtol=1e-6)


def test_level_camera_fits_the_box_mean():
    """The column of a ray, 10 + 3 x/z at level 0, is read at the same ray of level 1."""
    columns = np.tile(np.arange(64, dtype=np.float32), (32, 1))
    level = image.ImagePyramid(columns)[1]
    finest = camera.PinholeCamera(3.0, 3.0, 10.0, 12.0)
    coarse = finest.at_level(1)
    assert coarse == camera.PinholeCamera(1.5, 1.5, 4.75, 5.75)
    ray = np.array([1.0, 0.5, 1.0])
    values, _, _ = image.sample(level, coarse.project(ray)[0])
    assert values == finest.project(ray)[0][0] == 13.0


def test_samples_end_at_the_border_pixels():
    pixels = np.ones((3, 5), np.float32)
    uv = [[0, 0], [4, 2], [4.001, 2], [4, 2.001], [-0.001, 0], [0, -0.001], [np.nan, 0]]
    for interpolation in image.SampleInterpolation:
        _, _, valid = image.sample(pixels, uv, interpolation=interpolation)
        assert valid.tolist() == [True] * 2 + [False] * 5
    pixels[1, 1] = np.nan
    assert image.sample(pixels, [[0.5, 0.5], [2.5, 0.5]])[2].tolist() == [False, True]


def test_no_depth_is_zero():
    D, V = depth.inverse_depth(np.array([[2.0, 0.0, np.nan]], np.float32))
    assert D.tolist() == [[0.5, 0.0, 0.0]]
    assert (V > 0).tolist() == [[True, False, False]]
    assert V[0, 1:].tolist() == [0.0, 0.0]
    D, V = image.DepthPyramid(np.float32([[1, 1, 0]]), np.float32([[1, -1, 1]]))[0]
    assert D.tolist() == V.tolist() == [[1.0, 0.0, 0.0]]


# --- residuals, cost, units ----------------------------------------------------------------------


def test_residual_is_predicted_minus_observed(tiny_problem: BalProblem):
    moved = tiny_problem.observations + np.array([3.0, -2.0])
    shifted = tiny_problem.replace(observations=moved)
    difference = shifted.residuals() - tiny_problem.residuals()
    np.testing.assert_allclose(difference, np.tile([-3.0, 2.0], (len(difference), 1)), rtol=1e-10)


def test_alignment_maps_host_to_target():
    """A target brighter by 12 that looks at the same wall from 10 cm nearer."""
    u, v = np.meshgrid(np.arange(160.0), np.arange(120.0))
    pinhole = camera.PinholeCamera(130.0, 130.0, 79.5, 59.5)

    def wall(z: float) -> np.ndarray:
        x, y = z * (u - 79.5) / 130.0, z * (v - 59.5) / 130.0
        texture = 110 + 40 * np.sin(11 * x) + 30 * np.cos(9 * y) + 25 * np.sin(6 * x + 7 * y)
        return texture.astype(np.float32)

    D = np.full((120, 160), 0.5, np.float32)
    keyframe = tracking.Keyframe(wall(2.0), pinhole, inverse_depth=D, variance=1e-6)
    result = tracking.align(keyframe, wall(1.9) + np.float32(12.0), maps=True)
    assert result.status is tracking.AlignmentStatus.OK
    np.testing.assert_allclose(result.T_th[:3, 3], [0.0, 0.0, -0.1], atol=2e-3)
    assert math.exp(result.a) * 128 + result.b == pytest.approx(116.0, abs=2.0)
    at_start = tracking.align(
        keyframe,
        wall(2.0) + np.float32(12.0),
        options=tracking.TrackingOptions(
            affine=tracking.AffineOptions(mode=tracking.AffineMode.NONE)
        ),
        maps=True,
    )
    assert np.nanmedian(at_start.maps.residual) == pytest.approx(-12.0, abs=1.0)


def test_cost_is_half_the_sum_of_rho(tiny_problem: BalProblem):
    squared = np.sum(tiny_problem.residuals() ** 2, axis=1)
    evaluate = BundleOptions(lm=LmOptions(max_num_iterations=0))
    summary = adjust(tiny_problem, options=evaluate).summary
    assert summary.initial_cost == pytest.approx(0.5 * squared.sum(), rel=1e-12)
    huber = evaluate.replace(loss=Loss.parse("huber:0.5"))
    rho = np.where(squared <= 0.25, squared, 2 * 0.5 * np.sqrt(squared) - 0.25)
    robust_cost = adjust(tiny_problem, options=huber).summary.initial_cost
    assert robust_cost == pytest.approx(0.5 * rho.sum(), rel=1e-12)


@pytest.mark.parametrize("kind", list(LossType), ids=lambda k: k.name)
def test_losses_start_as_least_squares(kind: LossType):
    """ρ(0) = 0, ρ′(0) = 1; for scale 2 and residual 4 px the law sees x = 4 (Huber: 2·2·4 − 4)."""
    rho, d_rho, _ = Loss(type=kind, scale=2.0).evaluate(np.array([0.0, 16.0]))
    assert rho[0] == 0.0
    assert d_rho[0] == pytest.approx(1.0, abs=1e-15)
    if kind is LossType.HUBER:
        assert rho[1] == 12.0


def test_lambda_starts_at_initial_lambda(tiny_problem: BalProblem):
    options = BundleOptions(lm=LmOptions(initial_lambda=0.125, max_num_iterations=1))
    iterations = adjust(tiny_problem, options=options).summary.iterations
    assert iterations["lambda"][0] == pytest.approx(0.125, rel=1e-12)


def test_times_end_in_s():
    """Every field of a summary that is a time says its unit, and nothing else ends so."""
    times = [
        n for n in (*_core.Summary.__fields__, *_core.IterationSummary.__fields__) if "time" in n
    ]
    assert len(times) >= 5
    assert all(name.endswith("_s") for name in times)
    assert all(n.endswith("_s") for n in LmOptions.__fields__ if "time" in n)


# --- options, summaries, callbacks ---------------------------------------------------------------


def test_options_nest_and_do_not_inherit():
    records = [c for c in vars(_core).values() if hasattr(c, "__fields__")]
    for cls in records:
        assert not [base for base in cls.__mro__[1:] if hasattr(base, "__fields__")]
    assert isinstance(BundleOptions().lm, LmOptions)
    assert not set(BundleOptions.__fields__) & set(BundleConfig.__fields__)


def test_options_error_names_field_rule_and_value():
    with pytest.raises(raylign.OptionsError) as caught:
        LmOptions(max_num_iterations=-1)
    assert str(caught.value) == "LmOptions.max_num_iterations must be >= 0, got -1"


def test_first_iteration_is_the_start(tiny_problem: BalProblem):
    empty = _core.Summary()
    assert empty.termination is Termination.NOT_RUN
    assert empty.initial_cost == empty.final_cost == -1.0
    assert not empty.is_usable()
    summary = adjust(tiny_problem).summary
    assert summary.iterations["iteration"].tolist() == list(range(len(summary.iterations)))
    assert summary.iterations["cost"][0] == summary.initial_cost
    assert summary.iterations["cost"].min() == summary.final_cost


def test_callback_stops_only_with_false(tiny_problem: BalProblem):
    seen: list[int] = []
    answers: dict[int, Any] = {0: None, 1: 0, 2: False}

    def callback(row: _core.IterationSummary) -> Any:
        seen.append(row.iteration)
        return answers[row.iteration]

    tight = LmOptions(function_tolerance=0.0, parameter_tolerance=0.0, gradient_tolerance=0.0)
    result = adjust(tiny_problem, options=BundleOptions(lm=tight), callback=callback)
    assert seen == [0, 1, 2]
    assert result.summary.termination is Termination.USER_STOPPED

    def fail(row: _core.IterationSummary) -> None:
        raise KeyError("from the callback")

    with pytest.raises(KeyError, match="from the callback"):
        adjust(tiny_problem, callback=fail)


def test_enums_are_python_enums():
    enums = [c for c in vars(_core).values() if isinstance(c, type) and issubclass(c, enum.Enum)]
    assert len(enums) >= 8
    for cls in enums:
        assert all(member.name == member.name.upper() for member in cls), cls
    for kind in LossType:
        assert Loss.parse(kind.name.lower()).type is kind


# --- errors and arrays ---------------------------------------------------------------------------


def test_format_error_names_file_line_and_field(tmp_path: Path):
    path = tmp_path / "bad.txt"
    path.write_text("1 1 1\n0 0 nonsense 2.0\n" + "0\n" * 12)
    with pytest.raises(raylign.FormatError) as caught:
        io.read_bal(path)
    error = caught.value
    assert error.file == str(path)
    assert error.line == 2
    assert "observation 0" in error.field
    assert error.reason
    assert str(error).startswith(f"{path}:2: ")


def test_wrong_arrays_are_refused(tiny_problem: BalProblem):
    points = tiny_problem.points
    wrong = [
        points.astype(np.float32),
        np.asfortranarray(points),
        points[:, :2].copy(),
        np.repeat(points, 2, axis=0)[::2],
        points.tolist(),
    ]
    for array in wrong:
        with pytest.raises(raylign.ShapeError, match="points"):
            tiny_problem.replace(points=array)


def test_adjust_leaves_its_input_alone(tiny_problem: BalProblem):
    before = tiny_problem.copy()
    result = adjust(tiny_problem)
    assert tiny_problem == before
    assert result.problem != before


def test_constant_blocks_come_back_bit_for_bit(tiny_problem: BalProblem):
    config = BundleConfig(
        gauge=Gauge.FIRST_CAMERA,
        constant_cameras=[2],
        constant_intrinsics=[1],
        constant_points=[0, 7],
    )
    after = adjust(tiny_problem, config=config).problem
    for index in (0, 2):
        assert same_bits(after.cameras[index, :6], tiny_problem.cameras[index, :6])
    assert same_bits(after.cameras[1, 6:], tiny_problem.cameras[1, 6:])
    assert same_bits(after.points[[0, 7]], tiny_problem.points[[0, 7]])
    assert not same_bits(after.cameras[1, :6], tiny_problem.cameras[1, :6])


def test_numerical_failure_is_no_exception(tiny_problem: BalProblem):
    """A point in a camera's centre has no pixel: no start, hence FAILURE; the input comes back."""
    tiny_problem.points[0] = tiny_problem.camera_centers()[0]
    result = adjust(tiny_problem)
    assert result.summary.termination is Termination.FAILURE
    assert result.summary.message
    assert result.problem == tiny_problem


# --- behaviour -----------------------------------------------------------------------------------


def test_one_thread_gives_the_same_bits(tiny_problem: BalProblem):
    """Eight solves whose memory lies elsewhere each time: nothing may depend on addresses."""
    first = adjust(tiny_problem)
    assert first.summary.deterministic
    held = []
    for size in range(7):
        held.append(np.ones(64 << size))
        again = adjust(tiny_problem)
        held.append(again)
        assert again.problem == first.problem
        assert same_bits(again.summary.iterations["cost"], first.summary.iterations["cost"])


def test_library_is_silent(tiny_problem: BalProblem, capfd: pytest.CaptureFixture[str]):
    """File descriptors are watched, so that prints of C++ and of Ceres' logger count too."""
    adjust(tiny_problem)
    tiny_problem.points[0] = tiny_problem.camera_centers()[0]
    adjust(tiny_problem)
    assert capfd.readouterr() == ("", "")


def test_same_seed_same_scene():
    np.random.seed(0)  # noqa: NPY002  # global state must not matter
    first = synthetic.bal(num_cameras=4, num_points=50, seed=3).problem
    np.random.seed(1)  # noqa: NPY002
    assert synthetic.bal(num_cameras=4, num_points=50, seed=3).problem == first
    assert synthetic.bal(num_cameras=4, num_points=50, seed=4).problem != first


# --- code ----------------------------------------------------------------------------------------


def public_modules() -> list[ModuleType]:
    names = [m.name for m in pkgutil.walk_packages(raylign.__path__, "raylign.")]
    return [importlib.import_module(n) for n in names if not re.search(r"\._|\.cli", n)]


def public_functions() -> list[tuple[str, Callable[..., Any]]]:
    return [
        (f"{module.__name__}.{name}", getattr(module, name))
        for module in public_modules()
        for name in getattr(module, "__all__", [])
        if inspect.isfunction(getattr(module, name))
    ]


def test_public_functions_are_snake_case():
    """The field's alphabet is allowed: frames after an underscore, `T_cw`, `J_point`."""
    pattern = re.compile(r"([a-z][a-z0-9]*|[A-Z])(_[a-z0-9]+)*_?")
    names = [name.rsplit(".", 1)[1] for name, _ in public_functions()]
    names += [n for n, f in vars(_core).items() if callable(f) and not isinstance(f, type)]
    names += [f for c in vars(_core).values() for f in getattr(c, "__fields__", ())]
    assert len(names) > 50
    assert [n for n in names if not n.startswith("__") and not pattern.fullmatch(n)] == []


def test_options_are_keyword_only():
    """No public function takes an argument with a default by position, unless it is the data."""
    data = {
        "raylign.synthetic.bal(options)",
        "raylign.viz.plot_point_cloud(after)",
        "raylign.viz.plot_residuals(after)",
    }
    wrong = [
        f"{name}({parameter.name})"
        for name, function in public_functions()
        for parameter in inspect.signature(function).parameters.values()
        if parameter.kind is parameter.POSITIONAL_OR_KEYWORD
        and parameter.default is not parameter.empty
    ]
    assert {re.sub(r"viz\.\w+\.", "viz.", name) for name in wrong} <= data


# --- the document --------------------------------------------------------------------------------


def test_document_and_tests_agree():
    """Each test named in the document exists once; each convention test here is in the document."""
    document = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
    named = re.findall(r"`(test_\w+)`", document)
    assert len(named) == len(set(named)) > 30
    sources = {p: p.read_text(encoding="utf-8") for p in (ROOT / "tests/python").rglob("test_*.py")}
    for name in named:
        places = [
            p for p, text in sources.items() if re.search(rf"^def {name}\(", text, re.MULTILINE)
        ]
        assert len(places) == 1, name
    here = re.findall(r"^def (test_\w+)\(", sources[Path(__file__).resolve()], re.MULTILINE)
    assert set(here) <= set(named)
