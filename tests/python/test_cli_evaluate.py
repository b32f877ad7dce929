"""`raylign evaluate`, and the pictures of a trajectory."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from typer.testing import CliRunner

import raylign
from raylign import trajectory, viz
from raylign.cli import app
from raylign.io import write_kitti_poses, write_tum_trajectory
from raylign.trajectory import Trajectory
from sequence_trees import make_tum
from test_trajectory import perturbed, straight, wandering


def run(*arguments: object):
    return CliRunner().invoke(app, ["evaluate", *map(str, arguments)])


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    truth = wandering()
    write_tum_trajectory(truth, tmp_path / "truth.txt")
    write_tum_trajectory(perturbed(truth)[:90], tmp_path / "estimate.txt")
    return tmp_path / "estimate.txt", tmp_path / "truth.txt"


def test_table_json_and_plot(files: tuple[Path, Path], tmp_path: Path):
    estimate, truth = files
    result = run(
        estimate, "--truth", truth, "--json", tmp_path / "a.json", "--plot", tmp_path / "a.png"
    )
    assert result.exit_code == 0, result.output
    expected = trajectory.evaluate(perturbed(wandering())[:90], wandering())
    numbers = json.loads((tmp_path / "a.json").read_text())
    for name, part in (("ate", expected.absolute), ("rpe_per_second", expected.per_second)):
        found = numbers[name]["translation_m"]
        assert found["rmse"] == pytest.approx(part.translation.rmse, rel=1e-12)
    assert numbers["num_matched"] == 90
    assert numbers["coverage"] == pytest.approx(0.75, abs=0.01)
    assert "90 of 90 poses matched with 120 true ones; coverage 75" in result.output
    row = re.search(r"ATE translation \[m\] +(\S+)", result.output)
    assert row is not None
    assert float(row[1]) == pytest.approx(expected.absolute.translation.rmse, abs=1e-6)
    assert "segment" not in result.output
    assert imread(tmp_path / "a.png").shape[0] > 600


def test_segments_and_alignments(files: tuple[Path, Path]):
    result = run(*files[:1], "--truth", files[1], "--align", "sim3", "--short-segments")
    assert result.exit_code == 0
    assert "scale 0.9" in result.output or "scale 1.0" in result.output
    assert len(re.findall(r"^ +\d\.\d+ +\d+ +\S+ +\S+ *$", result.output, re.MULTILINE)) == 8
    for align in ("none", "first_pose", "SE3"):
        assert run(files[0], "--truth", files[1], "--align", align, "-q").output == ""


def test_kitti_files(tmp_path: Path):
    truth = wandering()
    write_kitti_poses(truth, tmp_path / "truth.txt")
    write_kitti_poses(perturbed(truth), tmp_path / "estimate.txt")
    both = (tmp_path / "estimate.txt", "--truth", tmp_path / "truth.txt", "--format", "kitti")
    assert "in 11.9 s" in run(*both).output
    (tmp_path / "times.txt").write_text("".join(f"{i / 30}\n" for i in range(120)))
    assert "in 3.967 s" in run(*both, "--timestamps", tmp_path / "times.txt").output
    refused = run(*both[:3], "--timestamps", tmp_path / "times.txt")
    assert refused.exit_code == 2


def test_the_truth_of_a_sequence(tmp_path: Path):
    make_tum(tmp_path / "fr1", num_frames=8)
    write_tum_trajectory(
        Trajectory.from_quaternions(
            1000.0 + np.arange(8) / 30, np.zeros((8, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (8, 1))
        ),
        tmp_path / "still.txt",
    )
    result = run(tmp_path / "still.txt", "--truth", tmp_path / "fr1", "--align", "none")
    assert result.exit_code == 0, result.output
    assert "8 of 8 poses" in result.output
    (tmp_path / "fr1" / "groundtruth.txt").unlink()
    assert run(tmp_path / "still.txt", "--truth", tmp_path / "fr1").exit_code == 1


def test_errors_are_one_line(files: tuple[Path, Path], tmp_path: Path):
    estimate, truth = files
    write_tum_trajectory(straight(), tmp_path / "line.txt")
    line = run(tmp_path / "line.txt", "--truth", tmp_path / "line.txt")
    assert line.exit_code == 1
    assert "on one line or in one place" in line.stderr
    (tmp_path / "bad.txt").write_text("0 1 2\n")
    bad = run(tmp_path / "bad.txt", "--truth", truth)
    assert bad.exit_code == 1
    assert "bad.txt:1: expected 8 numbers" in bad.stderr
    assert "unit of the stamps" in run(tmp_path / "line.txt", "--truth", truth).stderr
    assert run(estimate, "--truth", truth, "--json", estimate).exit_code == 2
    assert run(estimate, "--truth", truth, "--plot", tmp_path / "a.txt").exit_code == 2
    assert run(estimate, "--truth", truth, "--max-difference-s", "-1").exit_code == 2


@pytest.mark.parametrize("up", ["", "x", "y", "z"])
def test_paths_are_drawn_from_above(up: str):
    """The estimate's line holds the aligned positions on the two axes that the labels name."""
    result = trajectory.evaluate(perturbed(wandering()), wandering())
    figure = viz.plot_trajectory(result, up=up)
    above, side = figure.axes[:2]
    axes = "xyz"
    names = [above.get_xlabel()[0], above.get_ylabel()[0]]
    line = above.get_lines()[1]
    positions = result.absolute.estimate.positions
    np.testing.assert_array_equal(line.get_xdata(), positions[:, axes.index(names[0])])
    np.testing.assert_array_equal(line.get_ydata(), positions[:, axes.index(names[1])])
    vertical = side.get_ylabel()[0]
    assert sorted([*names, vertical]) == ["x", "y", "z"]
    extent = np.ptp(wandering().positions, axis=0)
    assert vertical == (up or axes[int(extent.argmin())])
    with pytest.raises(raylign.OptionsError, match="up must be"):
        viz.plot_trajectory(result, up="w")


def test_a_gap_breaks_the_line_and_one_pose_is_drawn():
    truth = wandering()
    keep = np.ones(120, bool)
    keep[40:60] = False
    result = trajectory.evaluate(truth[keep], truth)
    drawn = viz.plot_trajectory(result).axes[0].get_lines()[1].get_xdata()
    assert np.isnan(drawn).sum() == 1
    one = trajectory.evaluate(truth[:1], truth, alignment=trajectory.Alignment.FIRST_POSE)
    assert len(viz.plot_trajectory(one).axes) == 4


@pytest.mark.data
def test_truth_against_itself(shared_data: Path):
    strip = shared_data / "tum_fr1_xyz_37"
    result = run(strip / "groundtruth.txt", "--truth", strip, "--short-segments")
    assert result.exit_code == 0
    assert "400 of 400 poses" in result.output
    row = re.search(r"ATE translation \[m\] +(\S+)", result.output)
    assert row is not None
    assert float(row[1]) == 0.0
