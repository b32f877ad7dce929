import copy
import gc
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import raylign
from raylign.io import read_bal
from raylign.scene import BalProblem, ProblemStatistics
from tiny_problem import make_tiny_problem

ARRAYS = ["cameras", "points", "camera_index", "point_index", "observations", "colors"]


def project(problem: BalProblem) -> tuple[np.ndarray, np.ndarray]:
    """Predicted pixels and depths by NumPy and SciPy alone."""
    camera = problem.cameras[problem.camera_index]
    R_cw = Rotation.from_rotvec(camera[:, :3])
    p_c = R_cw.apply(problem.points[problem.point_index]) + camera[:, 3:6]
    xy = -p_c[:, :2] / p_c[:, 2:]
    r2 = np.sum(xy**2, axis=1, keepdims=True)
    f, k1, k2 = camera[:, 6:7], camera[:, 7:8], camera[:, 8:9]
    return f * (1.0 + k1 * r2 + k2 * r2**2) * xy, -p_c[:, 2]


def arrays_of(problem: BalProblem) -> dict[str, np.ndarray]:
    return {name: np.array(getattr(problem, name)) for name in ARRAYS}


def random_similarity(seed: int) -> np.ndarray:
    S = np.eye(4)
    rng = np.random.default_rng(seed)
    S[:3, :3] = 3.7 * Rotation.random(rng=rng).as_matrix()
    S[:3, 3] = rng.normal(size=3)
    return S


class TestConstruction:
    def test_keeps_every_number(self):
        arrays = arrays_of(make_tiny_problem())
        arrays["colors"] = np.arange(60, dtype=np.uint8).reshape(20, 3)
        problem = BalProblem(**arrays)
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(problem, name), arrays[name], strict=True)
        assert (problem.num_cameras, problem.num_points, problem.num_observations) == (4, 20, 80)

    def test_copies_its_input(self):
        arrays = arrays_of(make_tiny_problem())
        problem = BalProblem(**arrays)
        arrays["points"][0] = 99.0
        assert problem.points[0, 0] != 99.0

    def test_empty(self):
        problem = BalProblem(
            np.empty((0, 9)),
            np.empty((0, 3)),
            np.empty(0, np.int32),
            np.empty(0, np.int32),
            np.empty((0, 2)),
        )
        assert problem.cost() == 0.0
        assert problem.cameras.shape == (0, 9)
        assert problem.T_cw().shape == (0, 4, 4)
        assert problem.statistics() == ProblemStatistics()
        assert problem.normalized()[0] == problem
        assert pickle.loads(pickle.dumps(problem)) == problem

    @pytest.mark.parametrize(
        ("name", "bad", "message"),
        [
            ("cameras", np.zeros((4, 9), np.float32), "float32"),
            ("cameras", np.zeros((4, 9), ">f8"), ">f8"),
            ("cameras", np.zeros((4, 8)), r"\(4, 8\)"),
            ("cameras", np.zeros(36), r"\(36,\)"),
            ("cameras", np.asfortranarray(np.zeros((4, 9))), "C order"),
            ("cameras", np.zeros((8, 9))[::2], "C order"),
            ("cameras", [[0.0] * 9] * 4, "list"),
            ("cameras", None, "NoneType"),
            ("points", np.zeros((20, 3), np.int64), "int64"),
            ("points", np.zeros((3, 20)), r"\(3, 20\)"),
            ("points", np.zeros((20, 3), object), "object"),
            ("camera_index", np.zeros(80, np.int64), "int64"),
            ("camera_index", np.zeros(80, np.uint32), "uint32"),
            ("camera_index", np.zeros(80), "float64"),
            ("camera_index", np.zeros((80, 1), np.int32), r"\(80, 1\)"),
            ("camera_index", np.zeros(160, np.int32)[::2], "C order"),
            ("camera_index", np.zeros(79, np.int32), "79 rows"),
            ("camera_index", np.full(80, -1, np.int32), r"camera_index\[0\] is -1"),
            ("camera_index", np.full(80, 4, np.int32), r"4, not in \[0, 4\)"),
            ("point_index", np.zeros(81, np.int32), "81 rows"),
            ("point_index", np.full(80, 20, np.int32), r"20, not in \[0, 20\)"),
            ("point_index", np.full(80, -(2**31), np.int32), "-2147483648"),
            ("observations", np.zeros((80, 3)), r"\(80, 3\)"),
            ("observations", np.zeros((79, 2)), "79"),
            ("observations", np.zeros((80, 2), complex), "complex"),
            ("colors", np.zeros((20, 3)), "float64"),
            ("colors", np.zeros((19, 3), np.uint8), "19 rows"),
            ("colors", np.zeros((20, 4), np.uint8), r"\(20, 4\)"),
        ],
    )
    def test_refuses(self, name, bad, message):
        arrays = arrays_of(make_tiny_problem()) | {name: bad}
        with pytest.raises(raylign.ShapeError, match=message) as caught:
            BalProblem(**arrays)
        assert isinstance(caught.value, ValueError)

    def test_data_is_positional_and_colors_keyword_only(self):
        arrays = arrays_of(make_tiny_problem())
        data = [arrays[name] for name in ARRAYS[:5]]
        assert BalProblem(*data) == make_tiny_problem()
        with pytest.raises(TypeError):
            BalProblem(*data, None)


class TestViews:
    @pytest.mark.parametrize("name", ARRAYS)
    def test_writes_go_through(self, name):
        problem = make_tiny_problem().replace(colors=np.zeros((20, 3), np.uint8))
        view = getattr(problem, name)
        assert view.flags.writeable
        assert view.flags.c_contiguous
        assert np.shares_memory(view, getattr(problem, name))
        view[-1] = 1
        assert np.all(getattr(problem, name)[-1] == 1)

    @pytest.mark.parametrize("name", ARRAYS[:5])
    def test_keeps_its_owner_alive(self, name):
        view = getattr(make_tiny_problem(), name)
        gc.collect()
        filler = [np.full(view.shape, 123, view.dtype) for _ in range(50)]  # reuse freed memory
        np.testing.assert_array_equal(view, getattr(make_tiny_problem(), name))
        assert len(filler) == 50

    @pytest.mark.parametrize("name", [*ARRAYS, "num_points"])
    def test_arrays_cannot_be_replaced_in_place(self, tiny_problem, name):
        with pytest.raises(AttributeError):
            setattr(tiny_problem, name, getattr(tiny_problem, name))

    def test_broken_index_is_found_before_it_is_used(self, tiny_problem):
        tiny_problem.point_index[5] = 20
        for compute in [
            tiny_problem.validate,
            tiny_problem.residuals,
            tiny_problem.depths,
            tiny_problem.cost,
            tiny_problem.statistics,
        ]:
            with pytest.raises(raylign.ShapeError, match=r"point_index\[5\] is 20"):
                compute()


class TestValueSemantics:
    @pytest.mark.parametrize(
        "duplicate",
        [
            BalProblem.copy,
            copy.copy,
            copy.deepcopy,
            BalProblem.replace,
            lambda problem: pickle.loads(pickle.dumps(problem)),
        ],
        ids=["copy", "copy.copy", "deepcopy", "replace", "pickle"],
    )
    def test_copies_are_equal_and_independent(self, tiny_problem, duplicate):
        other = duplicate(tiny_problem)
        assert other == tiny_problem
        other.points[3, 1] += 1e-15
        assert other != tiny_problem
        assert tiny_problem == make_tiny_problem()

    @pytest.mark.parametrize("name", ARRAYS[:5])
    def test_equality_sees_every_array(self, tiny_problem, name):
        other = tiny_problem.copy()
        array = getattr(other, name)
        array.flat[0] = (array.flat[0] + 1) % 2
        assert other != tiny_problem

    def test_equality_is_bitwise(self, tiny_problem):
        other = tiny_problem.copy()
        tiny_problem.points[0] = 0.0
        other.points[0] = -0.0
        assert other != tiny_problem
        other.points[0] = tiny_problem.points[0] = np.nan
        assert other == tiny_problem

    def test_other_types_are_unequal(self, tiny_problem):
        assert tiny_problem != 3
        assert tiny_problem != "problem"

    def test_replace_checks(self, tiny_problem):
        with pytest.raises(raylign.ShapeError):
            tiny_problem.replace(points=tiny_problem.points[:3].copy())
        with pytest.raises(TypeError):
            tiny_problem.replace(point=tiny_problem.points)

    def test_repr(self, tiny_problem):
        assert repr(tiny_problem) == "<BalProblem: 4 cameras, 20 points, 80 observations>"


class TestResiduals:
    def test_match_numpy(self, tiny_problem):
        rng = np.random.default_rng(1)
        tiny_problem.cameras[:, :6] += rng.normal(0.0, 0.3, (4, 6))
        predicted, depth = project(tiny_problem)
        expected = predicted - tiny_problem.observations
        scale = np.abs(expected).max()
        np.testing.assert_allclose(tiny_problem.residuals(), expected, rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(tiny_problem.depths(), depth, rtol=1e-13)
        assert tiny_problem.cost() == pytest.approx(0.5 * np.sum(expected**2), rel=1e-12)

    def test_sign_is_predicted_minus_observed(self, tiny_problem):
        before = tiny_problem.residuals()
        tiny_problem.observations[:] += [1.0, 2.0]
        np.testing.assert_allclose(tiny_problem.residuals() - before, [[-1.0, -2.0]] * 80)

    def test_depth_is_positive_in_front(self, tiny_problem):
        assert (tiny_problem.depths() > 0).all()

    def test_point_on_the_camera_plane_gives_nan_and_is_counted(self, tiny_problem):
        tiny_problem.cameras[0, :6] = 0.0
        tiny_problem.points[0] = [1.0, 1.0, 0.0]
        assert np.isnan(tiny_problem.residuals()[0]).all()
        assert np.isnan(tiny_problem.cost())
        statistics = tiny_problem.statistics()
        assert statistics.num_non_finite == 1
        assert np.isfinite([statistics.cost, statistics.rmse, statistics.median_error]).all()

    @pytest.mark.data
    @pytest.mark.parametrize(
        ("file", "cost"),
        [("problem-49-7776-pre.txt", 8.509125e5), ("problem-21-11315-pre.txt", 4.413239e6)],
    )
    def test_start_costs_of_real_problems(self, shared_data, file, cost):
        problem = read_bal(shared_data / "bal" / file)
        predicted, depth = project(problem)
        oracle = 0.5 * np.sum((predicted - problem.observations) ** 2)
        assert problem.cost() == pytest.approx(oracle, rel=1e-12)
        assert problem.cost() == pytest.approx(cost, rel=1e-6)
        assert problem.statistics().num_behind_camera == np.sum(depth <= 0)


class TestStatistics:
    def test_counts(self, tiny_problem):
        keep = np.ones(80, bool)
        keep[[0, 20, 40, 60]] = False  # point 0: unseen
        keep[[1, 21, 41]] = False  # point 1: seen once
        keep[62:] = False  # camera 3: sees points 1 only
        problem = tiny_problem.replace(
            camera_index=np.append(tiny_problem.camera_index[keep], np.int32(0)),
            point_index=np.append(tiny_problem.point_index[keep], np.int32(2)),
            observations=np.vstack([tiny_problem.observations[keep], [[0.0, 0.0]]]),
        )
        problem.cameras[1, 6] = -500.0
        statistics = problem.statistics()
        per_point = np.bincount(problem.point_index, minlength=20)
        per_camera = np.bincount(problem.camera_index, minlength=4)
        assert statistics.num_unobserved_points == 1
        assert statistics.num_underconstrained_points == 2
        assert statistics.num_unobserved_cameras == 0
        assert statistics.num_underconstrained_cameras == 1
        assert statistics.num_duplicate_observations == 1
        assert statistics.num_non_positive_focal == 1
        assert statistics.track_length_histogram == np.bincount(per_point).tolist()
        for summary, counts in [
            (statistics.observations_per_point, per_point),
            (statistics.observations_per_camera, per_camera),
        ]:
            assert summary.min == counts.min()
            assert summary.max == counts.max()
            assert summary.mean == pytest.approx(counts.mean())
            assert summary.median == np.median(counts)

    def test_errors(self, tiny_problem):
        tiny_problem.points[7] = [0.0, 0.0, 50.0]  # behind every camera
        norms = np.linalg.norm(tiny_problem.residuals(), axis=1)
        statistics = tiny_problem.statistics()
        assert statistics.num_behind_camera == 4
        assert statistics.cost == pytest.approx(tiny_problem.cost())
        assert statistics.rmse == pytest.approx(np.sqrt(np.sum(norms**2) / 160))
        assert statistics.median_error == pytest.approx(np.median(norms))
        assert statistics.max_error == pytest.approx(norms.max())

    def test_value_semantics(self, tiny_problem):
        statistics = tiny_problem.statistics()
        assert pickle.loads(pickle.dumps(statistics)) == statistics
        assert statistics.to_dict()["num_cameras"] == 4
        assert "rmse=" in repr(statistics)


class TestTransforms:
    def test_cost_is_invariant(self, tiny_problem):
        moved = tiny_problem.transformed(random_similarity(3))
        assert moved.cost() == pytest.approx(tiny_problem.cost(), rel=1e-12)
        np.testing.assert_allclose(moved.depths(), 3.7 * tiny_problem.depths(), rtol=1e-13)

    def test_undo(self, tiny_problem):
        S = random_similarity(4)
        back = tiny_problem.transformed(S).transformed(np.linalg.inv(S))
        np.testing.assert_allclose(back.points, tiny_problem.points, rtol=0, atol=1e-12)
        np.testing.assert_allclose(back.cameras, tiny_problem.cameras, rtol=0, atol=1e-12)

    def test_points_move_by_the_matrix(self, tiny_problem):
        S = random_similarity(5)
        expected = tiny_problem.points @ S[:3, :3].T + S[:3, 3]
        np.testing.assert_allclose(tiny_problem.transformed(S).points, expected, atol=1e-14)

    def test_identity_is_verbatim(self, tiny_problem):
        assert tiny_problem.transformed(np.eye(4)) == tiny_problem

    @pytest.mark.parametrize(
        "S",
        [
            np.diag([1.0, 1.0, 2.0, 1.0]),
            np.diag([1.0, 1.0, -1.0, 1.0]),
            np.zeros((4, 4)),
            np.full((4, 4), np.nan),
            np.diag([1.0, 1.0, 1.0, 2.0]),
        ],
    )
    def test_refuses_what_is_no_similarity(self, tiny_problem, S):
        with pytest.raises(raylign.ShapeError):
            tiny_problem.transformed(S)

    def test_normalized(self, tiny_problem):
        tiny_problem = tiny_problem.replace(colors=np.full((20, 3), 9, np.uint8))
        original = tiny_problem.copy()
        normalized, S_nw = tiny_problem.normalized(extent=100.0)
        assert tiny_problem == original
        assert normalized.cost() == pytest.approx(tiny_problem.cost(), rel=1e-12)
        np.testing.assert_array_equal(normalized.colors, tiny_problem.colors)
        np.testing.assert_array_equal(
            normalized.cameras[:, [0, 1, 2, 6, 7, 8]], tiny_problem.cameras[:, [0, 1, 2, 6, 7, 8]]
        )
        # The upper of the two middle values stands for the median of an even number of points.
        upper_median = np.sort(normalized.points, axis=0)[10]
        np.testing.assert_allclose(upper_median, 0.0, atol=1e-12)
        assert np.sort(np.abs(normalized.points).sum(axis=1))[10] == pytest.approx(100.0)
        back = normalized.transformed(np.linalg.inv(S_nw))
        np.testing.assert_allclose(back.points, tiny_problem.points, rtol=0, atol=1e-12)
        np.testing.assert_allclose(back.cameras, tiny_problem.cameras, rtol=0, atol=1e-12)

    def test_normalized_ignores_points_that_are_not_finite(self, tiny_problem):
        tiny_problem.points[::4] = np.nan
        normalized, S_nw = tiny_problem.normalized()
        assert np.isfinite(S_nw).all()
        assert np.isfinite(np.delete(normalized.points, np.s_[::4], axis=0)).all()

    def test_normalized_with_all_points_in_one_place_only_moves(self, tiny_problem):
        tiny_problem.points[:] = [1.0, 2.0, 3.0]
        normalized, S_nw = tiny_problem.normalized()
        assert (normalized.points == 0.0).all()
        np.testing.assert_array_equal(S_nw[:3, :3], np.eye(3))

    @pytest.mark.parametrize("extent", [0.0, -1.0, np.inf, np.nan])
    def test_normalized_refuses_extent(self, tiny_problem, extent):
        with pytest.raises(raylign.OptionsError, match="extent"):
            tiny_problem.normalized(extent=extent)

    @pytest.mark.data
    def test_real_problem_survives_normalisation(self, shared_data):
        problem = read_bal(shared_data / "bal" / "problem-49-7776-pre.txt")
        normalized, S_nw = problem.normalized()
        assert normalized.cost() == pytest.approx(problem.cost(), rel=1e-12)
        back = normalized.transformed(np.linalg.inv(S_nw))
        scale = np.abs(problem.points).max()
        np.testing.assert_allclose(back.points, problem.points, rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(back.cameras, problem.cameras, rtol=0, atol=1e-12 * scale)


class TestPoses:
    def test_match_scipy(self, tiny_problem):
        R_cw = Rotation.from_rotvec(tiny_problem.cameras[:, :3]).as_matrix()
        t_cw = tiny_problem.cameras[:, 3:6]
        np.testing.assert_allclose(tiny_problem.T_cw()[:, :3, :3], R_cw, atol=1e-15)
        np.testing.assert_array_equal(tiny_problem.T_cw()[:, :3, 3], t_cw)
        np.testing.assert_array_equal(tiny_problem.T_cw()[:, 3], [[0.0, 0.0, 0.0, 1.0]] * 4)
        np.testing.assert_allclose(
            tiny_problem.camera_centers(), -np.einsum("cji,cj->ci", R_cw, t_cw), atol=1e-14
        )
