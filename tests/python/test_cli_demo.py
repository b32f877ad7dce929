"""`raylign demo` end to end, and where its data comes from."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from raylign import _resources, cli, viz
from raylign.cli.demo import Scene
from raylign.io import read_bal


def test_demo_improves_and_draws(tmp_path: Path) -> None:
    output = tmp_path / "demo [px]"  # brackets: a path is not markup
    result = CliRunner().invoke(cli.app, ["demo", "-o", str(output)], env={"COLUMNS": "100"})
    assert result.exit_code == 0, result.output
    record = json.loads((output / "summary.json").read_text())
    assert record["summary"]["termination"] == "convergence"
    error = record["truth"]["camera_center_rmse"]
    assert error["after"] < 0.2 * error["before"]
    assert record["problem"]["after"]["rmse"] < record["problem"]["before"]["rmse"]
    assert len(list(output.glob("*.png"))) == 4
    assert f"pictures: {output / 'index.html'}" in result.stdout
    assert "median ‖r‖ [px]" in result.stdout


def test_street_has_outliers_and_gets_better_with_a_robust_loss(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record: dict[str, Any] = {}
    monkeypatch.setattr(viz, "bundle_report", lambda *_args, **words: record.update(words))
    arguments = ["demo", "--scene", "street", "-o", str(tmp_path), "--quiet"]
    result = CliRunner().invoke(cli.app, arguments)
    assert result.exit_code == 0, result.output
    assert result.output == ""
    error = record["extra"]["truth"]["camera_center_rmse"]
    assert error["after"] < error["before"]


@pytest.mark.slow
def test_room_is_refined_from_grey_values(tmp_path: Path) -> None:
    result = CliRunner().invoke(cli.app, ["demo", "--scene", "room", "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output
    record = json.loads((tmp_path / "summary.json").read_text())
    assert record["accepted"] is True
    assert record["median_rms"]["after"] < 0.5 * record["median_rms"]["before"]
    assert len(list(tmp_path.glob("*.png"))) == 6
    assert "camera centres off by" in result.stdout


@pytest.mark.parametrize("scene", [Scene.ORBIT, Scene.STREET])
def test_every_scene_is_shipped_with_its_truth(scene: Scene) -> None:
    before = read_bal(_resources.data_file(f"bal/{scene}.txt.gz"))
    truth = read_bal(_resources.data_file(f"bal/{scene}-truth.txt.gz"))
    assert (before.observations == truth.observations).all()


def test_installed_data_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shipped = _resources.data_file("registry.toml")
    assert shipped.is_file()
    monkeypatch.setattr(_resources, "_PACKAGE", tmp_path)
    (tmp_path / "_data").mkdir()
    (tmp_path / "_data" / "registry.toml").write_text("")
    assert _resources.data_file("registry.toml") == tmp_path / "_data" / "registry.toml" != shipped
    with pytest.raises(FileNotFoundError, match=r"none\.txt"):
        _resources.data_file("none.txt")
