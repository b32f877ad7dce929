"""`raylign photometric`: files in, files out, log lines, exit statuses."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from photometric_scene import CAMERA, centres, small_scene
from raylign import io
from raylign.cli import app
from raylign.cli.photometric import CovarianceChoice, LawChoice, PresetName, WarpChoice
from raylign.photometric import CovarianceScope, PatchWarp, PhotometricOptions, preset

RUNNER = CliRunner()
CAMERA_TEXT = "140,140,79.5,59.5"
FAST = ["--num-levels", "1", "--max-num-rounds", "1", "--camera", CAMERA_TEXT]


@pytest.fixture(scope="module")
def scene():
    return small_scene()


@pytest.fixture(scope="module")
def folder(scene, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("photometric")
    scene.write(path)
    return path


def run(*arguments: object):
    return RUNNER.invoke(app, ["photometric", *map(str, arguments)])


def test_refines_a_folder(scene, folder: Path, tmp_path: Path):
    done = run(folder, "-o", tmp_path, "--no-report", *FAST)
    assert done.exit_code == 0, done.output
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"points.txt", "poses.txt", "before.ply", "after.ply", "summary.json"}
    T_cw = io.read_poses(tmp_path / "poses.txt").T_cw
    errors = [np.linalg.norm(centres(T) - centres(scene.T_true)) for T in (scene.T_start, T_cw)]
    assert errors[1] < errors[0]
    record = json.loads((tmp_path / "summary.json").read_text())
    assert record["accepted"] is True
    assert len(record["images"]) == 3
    assert record["options"]["num_levels"] == 1
    assert "accepted" in done.output
    assert re.search(r"^ +1 ", done.output, re.MULTILINE)  # a row of the table


@pytest.mark.slow
def test_report_has_every_picture(folder: Path, tmp_path: Path):
    done = run(folder, "-o", tmp_path, "-q", *FAST)
    assert done.exit_code == 0, done.output
    page = (tmp_path / "index.html").read_text()
    pictures = sorted(path.name for path in tmp_path.glob("*.png"))
    assert pictures == [
        "cost.png", "images.png", "patches.png", "point_cloud.png", "points_by_error.png",
        "residuals.png",
    ]  # fmt: skip
    assert all(name in page for name in pictures)
    assert done.output == ""


def test_exercise_logs_like_g2o(folder: Path, tmp_path: Path):
    done = run(
        folder, "-o", tmp_path, "--no-report", "--preset", "exercise", "--camera", CAMERA_TEXT,
        "--max-num-iterations", 4,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    lines = [line for line in done.output.splitlines() if line.startswith("iteration= ")]
    assert lines[0].startswith("iteration= 0  chi2= ")
    pattern = (
        r"iteration= \d+  chi2= [\d.]+  time= \S+  cumTime= \S+  edges= \d+  schur= 1  "
        r"lambda= [\d.]+  levenbergIter= \d+"
    )
    assert all(re.fullmatch(pattern, line) for line in lines)
    chi2 = [float(re.search(r"chi2= ([\d.]+)", line).group(1)) for line in lines]
    assert chi2 == sorted(chi2, reverse=True)
    assert float(re.search(r"start chi2= ([\d.]+)", done.output).group(1)) > chi2[0]


@pytest.mark.parametrize(
    ("change", "arguments", "status", "message"),
    [
        (None, [], 2, "give --camera FX,FY,CX,CY"),
        (None, ["--camera", "1,2,3"], 2, "four numbers FX,FY,CX,CY, got '1,2,3'"),
        (None, ["--camera", "140,140,300,60"], 2, "160 x 120 px"),
        (None, [*FAST, "--pattern", "9x9"], 2, "9x9"),
        (None, [*FAST, "--pattern", "3x3"], 1, "9"),
        (lambda f: (f / "1.png").unlink(), FAST, 1, "3 images expected but 2 found, 1.png is miss"),
        (lambda f: (f / "poses.txt").unlink(), FAST, 1, "poses.txt: cannot be opened"),
        (
            lambda f: (f / "points.txt").write_text("1 2 3 4 5\n1 2 3 4\n1 2 3 4 5\n"),
            FAST, 1, "5 numbers expected but 4 found in line 2",
        ),
    ],
)  # fmt: skip
def test_mistakes_are_one_line(folder, tmp_path: Path, change, arguments, status, message):
    copy = tmp_path / "in"
    shutil.copytree(folder, copy)
    if change is not None:
        change(copy)
    done = run(copy, "-o", tmp_path / "out", *arguments)
    assert done.exit_code == status, done.output
    assert message in " ".join(done.stderr.split())
    assert "Traceback" not in done.output
    assert not (tmp_path / "out").exists()


def test_a_calibration_in_the_folder_is_found(folder: Path, tmp_path: Path):
    copy = tmp_path / "in"
    shutil.copytree(folder, copy)
    text = f"camera: {{fx: {CAMERA.fx}, fy: {CAMERA.fy}, cx: {CAMERA.cx}, cy: {CAMERA.cy}}}"
    (copy / "calibration.yaml").write_text(text)
    done = run(copy, "-o", tmp_path / "out", "--no-report", "-q", *FAST[:4])
    assert done.exit_code == 0, done.output


def test_choices_are_the_librarys():
    assert {c.value for c in WarpChoice} == {w.name.lower() for w in PatchWarp}
    assert {c.value for c in CovarianceChoice} == {c.name.lower() for c in CovarianceScope}
    for choice in LawChoice:
        assert PhotometricOptions().noise.replace(loss=choice.value)
    for name in PresetName:
        assert preset(name.value)


@pytest.mark.slow
@pytest.mark.data
def test_the_exercise_starts_where_it_says(shared_data: Path, tmp_path: Path):
    source = shared_data / "direct_ba"
    for name in ("points.txt", "poses.txt", *(f"{i}.png" for i in range(1, 7))):
        (tmp_path / name).symlink_to(source / name)
    (tmp_path / "0.png").symlink_to(source / "1.png")  # as the exercise did
    done = run(
        tmp_path, "-o", tmp_path / "out", "--no-report", "--preset", "exercise",
        "--max-num-iterations", 1,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert float(re.search(r"start chi2= ([\d.]+)", done.output).group(1)) == pytest.approx(
        4_430_756, abs=5
    )
    line = next(row for row in done.output.splitlines() if row.startswith("iteration= 0"))
    assert float(re.search(r"chi2= ([\d.]+)", line).group(1)) == pytest.approx(4_155_163, abs=5)
    assert float(re.search(r"lambda= ([\d.]+)", line).group(1)) == pytest.approx(
        370_502.93, abs=0.1
    )
