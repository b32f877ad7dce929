"""`raylign synthetic bal`: every option of the generator, by the same name."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from raylign import cli, synthetic
from raylign.io import read_bal, read_npz

SMALL = ["--num-cameras", "8", "--num-points", "100"]


def run(*arguments: str | Path) -> Result:
    texts = [str(argument) for argument in arguments]
    return CliRunner().invoke(cli.app, ["synthetic", "bal", *texts], env={"COLUMNS": "200"})


def test_file_is_what_the_library_makes(tmp_path: Path) -> None:
    target, truth = tmp_path / "a.txt.gz", tmp_path / "b.txt"
    result = run("-o", target, "--truth", truth, *SMALL, "--kind", "orbit", "--seed", "5")
    assert result.exit_code == 0, result.output
    expected = synthetic.bal(kind="orbit", num_cameras=8, num_points=100, seed=5)
    without_colors = {"colors": expected.problem.colors[:0]}
    assert read_bal(target) == expected.problem.replace(**without_colors)
    assert read_bal(truth) == expected.truth.replace(**without_colors)
    assert [line.split()[1] for line in result.stdout.splitlines()] == [str(target), str(truth)]


def test_every_option_is_there_with_its_default() -> None:
    text = run("--help").stdout
    for name in synthetic.BalOptions.__fields__:
        assert f"--{name.replace('_', '-')} " in text


@pytest.mark.parametrize(
    "changes",
    [
        {"num_observations": 220},
        {"pixel_noise": 2.0},
        {"far_fraction": 0.25},
        {"outlier_fraction": 0.1, "k1": 0.0},
    ],
)
def test_options_arrive(tmp_path: Path, changes: dict[str, float]) -> None:
    target = tmp_path / "a.txt"
    words = [str(w) for k, v in changes.items() for w in (f"--{k.replace('_', '-')}", v)]
    assert run("-o", target, *SMALL, *words).exit_code == 0
    expected = synthetic.bal(num_cameras=8, num_points=100, **changes).problem
    assert read_bal(target) == expected.replace(colors=expected.colors[:0])


def test_npz_keeps_the_colors(tmp_path: Path) -> None:
    target, truth = tmp_path / "a.npz", tmp_path / "b.txt"
    result = run("-o", target, "--truth", truth, *SMALL)
    assert result.exit_code == 0, result.output
    expected = synthetic.bal(num_cameras=8, num_points=100)
    assert read_npz(target) == expected.problem
    assert read_bal(truth) == expected.truth.replace(colors=expected.truth.colors[:0])


def test_refusals(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    for arguments, word in (
        ([*SMALL, "--num-cameras", "1"], "num_cameras"),
        ([*SMALL, "--kind", "ocean"], "--kind"),
        ([*SMALL, "--truth", target], "same file"),
        (["--truth", tmp_path / "b.ply"], "b.ply"),
    ):
        result = run("-o", target, *arguments)
        assert result.exit_code == 2
        assert word in result.stderr
        assert "Traceback" not in result.stderr
    assert run(*SMALL).exit_code == 2  # no --output
    assert run("-o", tmp_path / "none" / "a.txt", *SMALL).exit_code == 1
    assert list(tmp_path.iterdir()) == []
