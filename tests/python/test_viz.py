"""The figures and the report: on a tiny problem, on degenerate ones, and what the files hold."""

import json
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from raylign import ShapeError, bundle, viz
from raylign._json import jsonable
from raylign.scene import BalProblem
from raylign.viz import cost as cost_module
from raylign.viz import point_cloud, residuals, sparsity
from tiny_problem import make_tiny_problem

PICTURES = ["point_cloud.png", "cost.png", "residuals.png", "sparsity.png"]


@pytest.fixture
def solved(tiny_problem: BalProblem) -> bundle.BundleResult:
    return bundle.adjust(tiny_problem)


def no_observations(problem: BalProblem) -> BalProblem:
    return problem.replace(
        camera_index=problem.camera_index[:0],
        point_index=problem.point_index[:0],
        observations=problem.observations[:0],
    )


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Path], bundle.Summary]:
    before = make_tiny_problem()
    after = bundle.adjust(before)
    written = viz.bundle_report(
        before,
        after.problem,
        after.summary,
        tmp_path_factory.mktemp("viz") / "a" / "report",
        options=bundle.BundleOptions(),
        config=bundle.BundleConfig(),
        title="A & <B>",
        extra={"truth": {"center_rmse": np.float64(0.5)}},
    )
    return written, after.summary


def test_report_writes_everything(report: tuple[list[Path], bundle.Summary]) -> None:
    written, _ = report
    folder = written[0].parent
    names = [*PICTURES, "summary.json", "index.html", "index.md"]
    assert [path.name for path in written] == names
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    for name in PICTURES:
        pixels = imread(folder / name)
        assert pixels.shape[0] > 300
        assert pixels.shape[1] > 1000
        assert pixels[..., :3].std() > 0.02, f"{name} is blank"
    page = (folder / "index.html").read_text()
    assert "A &amp; &lt;B&gt;" in page
    for name in PICTURES:
        assert f'src="{name}"' in page
        assert f"({name})" in (folder / "index.md").read_text()


def test_summary_json(report: tuple[list[Path], bundle.Summary]) -> None:
    written, summary = report
    text = (written[0].parent / "summary.json").read_text()
    record = json.loads(text)
    assert record["summary"]["final_cost"] == summary.final_cost
    assert record["summary"]["termination"] == summary.termination.name.lower()
    assert "rho" in record["units"]["summary.*cost*"]
    assert "plain squares" in record["units"]["problem.*.cost"]
    page = (written[0].parent / "index.html").read_text()
    assert "points behind their camera" in page
    assert "median ‖r‖" in page
    assert len(record["summary"]["iterations"]) == len(summary.iterations)
    assert record["options"]["lm"]["max_num_iterations"] == 50
    assert float(record["options"]["lm"]["max_solver_time_s"]) == float("inf")
    assert record["config"]["gauge"] == "free"
    assert set(record["problem"]) == {"before", "after"}
    assert record["truth"] == {"center_rmse": 0.5}
    assert record["build"]["ceres"]
    assert str(Path.home()) not in text
    assert str(Path(__file__).parents[2]) not in text


def test_plots_leave_matplotlib_alone(
    tiny_problem: BalProblem, solved: bundle.BundleResult
) -> None:
    settings = dict(mpl.rcParams)
    for figure in (
        viz.plot_point_cloud(tiny_problem, solved.problem),
        viz.plot_point_cloud(tiny_problem),
        viz.plot_cost(solved.summary),
        viz.plot_residuals(tiny_problem, solved.problem),
        viz.plot_sparsity(tiny_problem),
    ):
        assert isinstance(figure, Figure)
        assert tuple(mpl.rcParams.items()) == tuple(settings.items())


def test_every_axis_is_labelled(tiny_problem: BalProblem, solved: bundle.BundleResult) -> None:
    figures = (
        viz.plot_point_cloud(tiny_problem, solved.problem),
        viz.plot_cost(solved.summary),
        viz.plot_residuals(tiny_problem, solved.problem),
        viz.plot_sparsity(tiny_problem),
    )
    for figure in figures:
        for axes in figure.axes:
            assert axes.get_ylabel()
            if axes.get_label() != "<colorbar>":
                assert axes.get_xlabel()


def test_point_cloud_axes_are_the_same_before_and_after_and_robust(
    tiny_problem: BalProblem, solved: bundle.BundleResult
) -> None:
    far = tiny_problem.copy()
    far.points[0] = [1e6, -1e6, 1e6]
    figure = viz.plot_point_cloud(far, solved.problem)
    before, after = figure.axes[0], figure.axes[1]
    assert before.get_xlim() == after.get_xlim()
    assert before.get_ylim() == after.get_ylim()
    assert np.ptp(before.get_xlim()) < 100
    assert before.get_aspect() == 1.0


def test_scene_frame_is_right_handed_with_cameras_upright(tiny_problem: BalProblem) -> None:
    frame = point_cloud._scene_frame(tiny_problem)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    # The tiny problem's cameras turn about y only: up is y.
    np.testing.assert_allclose(frame[2], [0.0, 1.0, 0.0], atol=1e-12)


def test_problem_colors_are_used(tiny_problem: BalProblem) -> None:
    colors = np.zeros((tiny_problem.num_points, 3), np.uint8)
    colors[:] = [255, 0, 0]
    figure = viz.plot_point_cloud(tiny_problem.replace(colors=colors))
    drawn = figure.axes[0].collections[0].get_facecolor()
    np.testing.assert_allclose(drawn[:, :3], [[1.0, 0.0, 0.0]] * tiny_problem.num_points)


def test_large_clouds_are_thinned_and_say_so(tiny_problem: BalProblem) -> None:
    figure = viz.plot_point_cloud(tiny_problem, max_points=7)
    assert len(figure.axes[0].collections[0].get_offsets()) == 7
    assert "7 points drawn" in figure.get_suptitle()


def test_camera_rmse(tiny_problem: BalProblem) -> None:
    norms = np.linalg.norm(tiny_problem.residuals(), axis=1)
    rmse = residuals._camera_rmse(tiny_problem, norms)
    for camera in range(tiny_problem.num_cameras):
        own = norms[tiny_problem.camera_index == camera]
        assert rmse[camera] == pytest.approx(np.sqrt(np.mean(own**2) / 2))
    norms[0] = np.nan
    assert np.isfinite(residuals._camera_rmse(tiny_problem, norms)).all()


def test_shared_points_is_the_pattern_of_s(tiny_problem: BalProblem) -> None:
    keep = np.random.default_rng(3).random(tiny_problem.num_observations) < 0.3
    problem = tiny_problem.replace(
        camera_index=tiny_problem.camera_index[keep],
        point_index=tiny_problem.point_index[keep],
        observations=tiny_problem.observations[keep],
    )
    sees = np.zeros((problem.num_points, problem.num_cameras))
    sees[problem.point_index, problem.camera_index] = 1
    np.testing.assert_array_equal(
        sparsity._shared_points(problem, problem.num_cameras), sees.T @ sees
    )


def test_sparsity_says_what_it_leaves_out(tiny_problem: BalProblem, shared_data: Path) -> None:
    assert "all of it" in viz.plot_sparsity(tiny_problem).axes[0].get_title(loc="left")
    from raylign.io import read_bal

    large = read_bal(shared_data / "bal" / "problem-21-11315-pre.txt")
    assert "first 16 cameras" in viz.plot_sparsity(large).axes[0].get_title(loc="left")


def test_rejected_steps_do_not_raise_the_curve(solved: bundle.BundleResult) -> None:
    rows = np.repeat(solved.summary.iterations[:1], 3)
    rows["iteration"] = [0, 1, 2]
    rows["cost"] = [10.0, 1e9, 4.0]
    rows["step_is_accepted"] = [False, False, True]
    np.testing.assert_array_equal(cost_module._best_cost(rows), [10.0, 10.0, 4.0])


def test_degenerate_problems_are_drawn(tiny_problem: BalProblem) -> None:
    first = tiny_problem.camera_index == 0
    one_camera = tiny_problem.replace(
        cameras=tiny_problem.cameras[:1].copy(),
        camera_index=tiny_problem.camera_index[first],
        point_index=tiny_problem.point_index[first],
        observations=tiny_problem.observations[first],
    )
    nothing = no_observations(tiny_problem)
    for figure in (
        viz.plot_point_cloud(one_camera),
        viz.plot_residuals(nothing, nothing),
        viz.plot_sparsity(nothing),
    ):
        figure.draw_without_rendering()


def test_nothing_to_draw_is_an_error(tiny_problem: BalProblem) -> None:
    empty = no_observations(tiny_problem).replace(points=np.zeros((0, 3)))
    for plot in (viz.plot_point_cloud, viz.plot_residuals, viz.plot_sparsity):
        with pytest.raises(ShapeError, match=f"{plot.__name__}: nothing to draw.* 0 points"):
            plot(empty)
    with pytest.raises(ShapeError, match="no iterations"):
        viz.plot_cost(bundle.Summary())


def test_one_problem_and_a_result_are_enough(
    tiny_problem: BalProblem, solved: bundle.BundleResult
) -> None:
    figure = viz.plot_residuals(tiny_problem)
    assert len(figure.axes) == 2
    assert len(figure.legends[0].get_texts()) == 1
    figure.draw_without_rendering()
    title = viz.plot_cost(solved).axes[1].get_title(loc="left")
    assert title == viz.plot_cost(solved.summary).axes[1].get_title(loc="left")


def test_camera_median(tiny_problem: BalProblem) -> None:
    norms = np.linalg.norm(tiny_problem.residuals(), axis=1)
    norms[3] = np.nan
    medians = residuals._camera_median(tiny_problem, norms)
    for camera in range(tiny_problem.num_cameras):
        own = norms[tiny_problem.camera_index == camera]
        assert medians[camera] == pytest.approx(np.nanmedian(own))
    assert np.isnan(residuals._camera_median(no_observations(tiny_problem), norms[:0])).all()
    figure = viz.plot_residuals(tiny_problem, tiny_problem, median=True)
    assert "median" in figure.axes[2].get_title(loc="left")


def failed_steps(solved: bundle.BundleResult) -> bundle.Summary:
    rows = np.repeat(solved.summary.iterations[:1], 4)
    rows["iteration"] = [0, 1, 2, 3]
    rows["cost"] = [1e5, 1e9, 1e5, 0.01]
    rows["step_norm"] = [0.0, 7.0, 0.0, 2.0]
    rows["step_is_valid"] = [True, True, False, True]
    rows["step_is_accepted"] = [True, False, False, True]
    return solved.summary.replace(iterations=rows)


def test_cost_tells_rejected_from_invalid_steps(solved: bundle.BundleResult) -> None:
    figure = viz.plot_cost(failed_steps(solved))
    over_iterations, state = figure.axes[1:]
    lines = {line.get_label(): line.get_xdata() for line in over_iterations.lines}
    np.testing.assert_array_equal(lines["rejected step"], [1])
    np.testing.assert_array_equal(lines["invalid step"], [2])
    crosses = [line for line in state.lines if line.get_marker() == "x"]
    np.testing.assert_array_equal(crosses[0].get_ydata(), [7.0])


def test_cost_axes_end_at_the_last_iteration_and_label_decades(
    solved: bundle.BundleResult,
) -> None:
    figure = viz.plot_cost(failed_steps(solved))
    for axes in figure.axes[1:]:
        assert axes.get_xlim()[1] == pytest.approx(3.0, abs=0.1)
    figure.draw_without_rendering()
    axis = figure.axes[1].yaxis
    exponents = np.log10(axis.get_majorticklocs())
    np.testing.assert_allclose(exponents, exponents.round(), atol=1e-9)
    assert not any(label.get_text() for label in axis.get_minorticklabels())


def test_many_cameras_are_thinned_and_say_so(
    tiny_problem: BalProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(point_cloud, "_MAX_CAMERAS", 2)
    figure = viz.plot_point_cloud(tiny_problem)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "camera (1 of 2 drawn)" in texts
    centers = figure.axes[0].collections[2].get_offsets()
    assert len(centers) == 2


def test_jsonable() -> None:
    value = {"a": np.int32(3), "b": [np.nan, np.inf], "c": bundle.Gauge.FREE, "d": (True, None)}
    assert jsonable(value) == {"a": 3, "b": ["nan", "inf"], "c": "free", "d": [True, None]}
    with pytest.raises(TypeError):
        jsonable(object())
