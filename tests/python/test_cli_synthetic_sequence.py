"""`raylign synthetic sequence`: a folder that the readers take, with its truth."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from raylign import cli, synthetic
from raylign.camera import PinholeCamera
from raylign.cli import _synthetic_sequence as command
from raylign.io import read_tum_rgbd

SMALL = ["--width", "64", "--height", "48", "-n", "3"]
CAMERA = PinholeCamera(52.5, 52.5, 31.5, 23.5)


def run(*arguments: str | Path) -> Result:
    texts = [str(argument) for argument in arguments]
    return CliRunner().invoke(cli.app, ["synthetic", "sequence", *texts], env={"COLUMNS": "200"})


def test_folder_is_what_the_library_renders(tmp_path: Path):
    result = run("-o", tmp_path / "a", *SMALL, "--motion", "arc", "--scene", "boxes", "--seed", "5")
    assert result.exit_code == 0, result.output
    assert "wrote 3 frames" in result.stdout
    sequence = read_tum_rgbd(tmp_path / "a")
    _, T_wc = synthetic.trajectory("arc", n=3)
    expected = synthetic.render_sequence(
        synthetic.boxes(seed=5),
        CAMERA,
        T_wc,
        width=64,
        height=48,
        sensor=synthetic.SensorOptions(read_noise=1.0, shot_noise=0.02),
        seed=5,
    )
    assert sequence.calibration.camera == CAMERA
    assert sequence.truth is not None
    assert np.abs(sequence.truth.T_wc - T_wc).max() < 1e-9
    for read, made in zip(sequence, expected, strict=True):
        assert np.array_equal(read.image, made.truth.image)
        assert np.array_equal(np.isfinite(read.depth), np.isfinite(made.depth))
        assert np.nanmax(np.abs(read.depth - made.depth)) < 1.01e-4


@pytest.mark.parametrize("scene", command.SceneKind)
def test_every_scene_is_rendered(tmp_path: Path, scene: str):
    result = run("-o", tmp_path, *SMALL, "--scene", scene, "--depth", "exact", "-q")
    assert result.exit_code == 0, result.output
    assert result.stdout == ""
    depth = read_tum_rgbd(tmp_path)[0].depth
    assert np.isfinite(depth).mean() > 0.95


def test_settings_arrive(tmp_path: Path):
    images = {}
    for name, words in {
        "plain": [],
        "again": ["--num-threads", "2"],
        "vignette": ["--vignette-r2", "-0.5"],
        "noise": ["--read-noise", "9"],
        "blur": ["--exposure-time", "1", "--motion", "x", "--extent", "1"],
        "supersample": ["--antialiasing", "supersample"],
        "focal": ["--focal", "80"],
        "exposure": ["--exposure-change", "0.5", "-n", "5"],
    }.items():
        assert run("-o", tmp_path / name, *SMALL, "--motion", "x", *words).exit_code == 0
        images[name] = read_tum_rgbd(tmp_path / name)[1].image.astype(float)
    assert np.array_equal(images["plain"], images["again"])
    for name in set(images) - {"plain", "again"}:
        assert not np.array_equal(images[name], images["plain"]), name
    assert images["exposure"].mean() > 1.4 * images["plain"].mean()
    assert images["vignette"][:4, :4].mean() < 0.7 * images["plain"][:4, :4].mean()


def test_enumerations_are_the_library_s():
    for ours, library in (
        (command.MotionKind, synthetic.Motion),
        (command.Antialias, synthetic.Antialiasing),
    ):
        assert [member.value for member in ours] == [member.name.lower() for member in library]


def test_refusals(tmp_path: Path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep me")
    for arguments, word, code in (
        (["-o", tmp_path / "full"], "not empty", 1),
        (["-o", tmp_path / "a", "--exposure-time", "2"], "exposure_time", 2),
        (["-o", tmp_path / "a", "--fps", "0"], "fps", 2),
        (["-o", tmp_path / "a", "--exposure-change", "-1.2", "-n", "5"], "exposure", 2),
        (["-o", tmp_path / "a", "--scene", "ocean"], "--scene", 2),
    ):
        result = run(*SMALL, *arguments)
        assert result.exit_code == code, result.output
        assert word in result.stderr
        assert "Traceback" not in result.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["full"]
