"""`raylign track`: what it writes and says."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import raylign
from raylign import io, synthetic
from raylign.camera import PinholeCamera
from raylign.cli import app
from raylign.cli import track as command

CAMERA = PinholeCamera(130.0, 130.0, 79.5, 59.5)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("sequences") / "room"
    arguments = ["--motion", "handheld", "--width", "160", "--height", "120", "--frames", "8"]
    result = CliRunner().invoke(app, ["synthetic", "sequence", "-o", str(path), *arguments, "-q"])
    assert result.exit_code == 0, result.output
    return path


def run(*arguments):
    return CliRunner().invoke(app, ["track", *map(str, arguments)])


def test_writes_everything(folder, tmp_path):
    out = tmp_path / "out"
    result = run(folder, "-o", out)
    assert result.exit_code == 0, result.output
    assert "8 of 8 frames tracked" in result.output
    assert "ATE" in result.output
    names = {path.name for path in out.iterdir()}
    assert names >= {
        "trajectory.txt", "keyframes.ply", "frames.jsonl", "summary.json", "index.html",
        "trajectory.png", "tracking.png", "normalised_residuals.png",
    }  # fmt: skip
    path = io.read_tum_trajectory(out / "trajectory.txt")
    rows = io.read_json_lines(out / "frames.jsonl")
    assert len(path) == len(rows) == 8
    assert [row["status"] for row in rows] == ["ok"] * 8
    np.testing.assert_allclose([row["T_wc"] for row in rows], path.T_wc, atol=1e-12)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["num_lost"] == 0
    assert summary["errors"]["ate"]["translation_m"]["rmse"] < 0.01


def test_selects_frames_and_draws_nothing(folder, tmp_path):
    result = run(folder, "-o", tmp_path, "--start", 2, "--step", 2, "--no-report", "--photometric")
    assert result.exit_code == 0, result.output
    assert "3 of 3 frames tracked" in result.output
    assert not list(tmp_path.glob("*.png"))
    assert (
        json.loads((tmp_path / "summary.json").read_text())["options"]["tracking"]["depth"][
            "enabled"
        ]
        is False
    )


def test_ctrl_c_keeps_what_is_there(folder, tmp_path, monkeypatch):
    original = command.Display.__call__

    def interrupt(self, result):
        original(self, result)
        if result.frame == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(command.Display, "__call__", interrupt)
    result = run(folder, "-o", tmp_path, "--no-report")
    assert result.exit_code == 130
    assert "stopped by Ctrl-C" in result.output
    assert len(io.read_tum_trajectory(tmp_path / "trajectory.txt")) == 5
    assert len(io.read_json_lines(tmp_path / "frames.jsonl")) == 5


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--start", 8], 2, "none is selected"),
        (["--format", "nonsense"], 2, "format must be"),
        (["--loss", "nonsense"], 2, "nonsense"),
        (["--format", "seven_scenes"], 1, "frame-"),
    ],
)
def test_errors_are_one_line(folder, tmp_path, arguments, status, message):
    result = run(folder, "-o", tmp_path, *arguments)
    assert result.exit_code == status, result.output
    assert message in result.output
    assert "Traceback" not in result.output


def test_a_run_without_a_truth_has_a_path(tmp_path):
    _, T_wc = synthetic.trajectory("x", n=4)
    frames = synthetic.render_sequence(synthetic.room(), CAMERA, T_wc, width=160, height=120)
    stamped = [
        type("Frame", (), {"image": f.truth.image, "depth": f.depth, "timestamp": i / 30})()
        for i, f in enumerate(frames)
    ]
    run_ = raylign.odometry.run(stamped, CAMERA)
    figure = raylign.viz.plot_path(run_.trajectory)
    assert len(figure.axes) == 2
    assert len(raylign.viz.plot_run(run_).axes) == 3
