"""The commands `bundle`, `convert`, `info` and the ways they fail."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import raylign
from raylign import bundle, cli, synthetic, viz
from raylign.cli import _choices as choices
from raylign.cli import bundle as bundle_command
from raylign.cli._options import parse_indices
from raylign.cli._progress import table_row
from raylign.io import read_bal, read_npz, write_bal, write_npz
from raylign.robust import Loss, LossType
from raylign.scene import BalProblem
from tiny_problem import make_tiny_problem


def run(*arguments: str | Path) -> Result:
    """Run in this process; COLUMNS keeps rich from folding lines."""
    return CliRunner().invoke(
        cli.app, [str(argument) for argument in arguments], env={"COLUMNS": "200"}
    )


def refused(result: Result, status: int, *words: str) -> None:
    """The command ended with `status` and one line on stderr that says `words`."""
    assert result.exit_code == status, result.output
    assert "Traceback" not in result.stderr
    for word in words:
        assert word in result.stderr
    if status == 1:
        assert result.stderr.startswith("error: ")
        assert result.stderr.count("\n") == 1


def assert_close(actual: BalProblem, expected: BalProblem) -> None:
    """Equal but for the rounding of two solves of the same problem."""
    assert actual.cost() == pytest.approx(expected.cost(), rel=1e-9)
    np.testing.assert_allclose(actual.cameras, expected.cameras, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(actual.points, expected.points, rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(actual.observations, expected.observations)


@pytest.fixture
def problem_file(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.txt"
    write_bal(make_tiny_problem(), path)
    return path


# --- the library's names ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("choice", "library"),
    [
        (choices.Backend, bundle.Backend),
        (choices.Pose, bundle.PoseParametrization),
        (choices.Point, bundle.PointParametrization),
        (choices.LinearSolver, bundle.LinearSolverType),
        (choices.Precondition, bundle.Preconditioner),
        (choices.GaugeChoice, bundle.Gauge),
    ],
)
def test_choices_are_the_library_enumerators(choice: type, library: type) -> None:
    assert [member.name for member in choice] == [member.name for member in library]
    assert [member.value for member in choice] == [member.name.lower() for member in library]
    for member in choice:
        assert choices.library_value(library, member).name == member.name


def test_version() -> None:
    result = run("--version")
    assert result.exit_code == 0
    assert result.stdout.strip() == f"raylign {raylign.__version__}"


@pytest.mark.parametrize(
    "command", [[], ["bundle"], ["convert"], ["info"], ["download"], ["demo"], ["synthetic", "bal"]]
)
def test_help(command: list[str]) -> None:
    assert run(*command, "--help").exit_code == 0


# --- bundle ----------------------------------------------------------------------------------


def test_bundle_gives_what_the_library_gives(problem_file: Path, tmp_path: Path) -> None:
    output = tmp_path / "refined.txt"
    result = run("bundle", problem_file, "-o", output)
    assert result.exit_code == 0, result.output
    expected = bundle.adjust(read_bal(problem_file))
    assert_close(read_bal(output), expected.problem)
    lines = result.stdout.splitlines()
    assert lines[0] == "tiny.txt: 4 cameras, 20 points, 80 observations"
    assert lines[1].split()[:2] == ["iter", "cost"]
    rows = [line.split() for line in lines[2 : 2 + len(expected.summary.iterations)]]
    for row, iteration in zip(rows, expected.summary.iterations, strict=True):
        assert int(row[0]) == iteration["iteration"]
        assert float(row[1]) == pytest.approx(iteration["cost"], rel=1e-6)
    assert any("convergence" in line for line in lines)


def test_bundle_all_outputs(problem_file: Path, tmp_path: Path) -> None:
    before, after, report = tmp_path / "b.ply", tmp_path / "a.ply", tmp_path / "report"
    output = tmp_path / "refined.npz"
    result = run(
        "bundle", problem_file, "-o", output, "--ply", before, after, "--report", report
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert before.read_bytes()[:4] == after.read_bytes()[:4] == b"ply\n"
    assert before.read_bytes() != after.read_bytes()
    record = json.loads((report / "summary.json").read_text())
    assert record["summary"]["final_cost"] == pytest.approx(read_npz(output).cost(), rel=1e-12)
    assert record["title"] == "Bundle adjustment of tiny.txt"
    assert len(list(report.glob("*.png"))) == 4
    for name in (output, before, after, report / "index.html"):
        assert str(name) in result.stdout


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The keywords of the one call of `bundle_report`, which draws nothing."""
    record: dict[str, Any] = {}
    monkeypatch.setattr(viz, "bundle_report", lambda *_args, **words: record.update(words))
    return record


def test_bundle_options_arrive(
    problem_file: Path, tmp_path: Path, recorded: dict[str, Any]
) -> None:
    result = run(
        "bundle", problem_file, "--quiet", "--report", tmp_path / "report",
        "--loss", "huber:1.5", "--pose", "quaternion", "--point", "homogeneous",
        "--linear-solver", "iterative_schur", "--preconditioner", "jacobi",
        "--max-num-linear-iterations", "77", "--forcing-tolerance", "0.01",
        "--gauge", "first_camera", "--constant-cameras", "1-2", "--constant-points", "0,5",
        "--constant-coordinate", "intrinsics:all:k2", "--constant-coordinate", "pose:3:tz",
        "--fix-intrinsics", "--max-num-iterations", "7", "--max-solver-time-s", "60",
        "--function-tolerance", "1e-7", "--gradient-tolerance", "1e-11",
        "--parameter-tolerance", "1e-9", "--initial-lambda", "1e-3", "--num-threads", "2",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert result.output == ""
    assert recorded["options"] == bundle.BundleOptions(
        pose_parametrization=bundle.PoseParametrization.QUATERNION,
        point_parametrization=bundle.PointParametrization.HOMOGENEOUS,
        loss=Loss(type=LossType.HUBER, scale=1.5),
        lm=bundle.LmOptions(
            max_num_iterations=7,
            max_solver_time_s=60.0,
            function_tolerance=1e-7,
            gradient_tolerance=1e-11,
            parameter_tolerance=1e-9,
            initial_lambda=1e-3,
            num_threads=2,
        ),
        linear_solver=bundle.LinearSolverOptions(
            type=bundle.LinearSolverType.ITERATIVE_SCHUR,
            preconditioner=bundle.Preconditioner.JACOBI,
            max_num_iterations=77,
            forcing_tolerance=0.01,
        ),
    )
    coordinate, intrinsics, pose = (
        bundle.ConstantCoordinate,
        bundle.ParameterKind.INTRINSICS,
        bundle.ParameterKind.POSE,
    )
    assert recorded["config"] == bundle.BundleConfig(
        gauge=bundle.Gauge.FIRST_CAMERA,
        constant_cameras=[1, 2],
        constant_intrinsics=[0, 1, 2, 3],
        constant_points=[0, 5],
        constant_coordinates=[
            coordinate(kind=intrinsics, index=-1, coordinate="k2"),
            coordinate(kind=pose, index=3, coordinate="tz"),
        ],
    )


def test_bundle_defaults_are_the_library_defaults(
    problem_file: Path, tmp_path: Path, recorded: dict[str, Any]
) -> None:
    assert run("bundle", problem_file, "--quiet", "--report", tmp_path / "r").exit_code == 0
    assert recorded["options"] == bundle.BundleOptions()
    assert recorded["config"] == bundle.BundleConfig()


def test_enumerators_in_either_case(problem_file: Path) -> None:
    words = ["--pose", "SE3", "--linear-solver", "Dense_Schur", "--log", "G2O"]
    result = run("bundle", problem_file, *words)
    assert result.exit_code == 0, result.output
    assert "chi2=" in result.stdout


def test_help_shows_names_whole_and_no_type_of_flags() -> None:
    shown = CliRunner().invoke(cli.app, ["bundle", "--help"], env={"COLUMNS": "80"}).stdout
    assert "<bool>" not in shown
    assert "…" not in shown
    assert "--max-num-linear-iterations " in shown
    assert "<bool>" not in run("--help").stdout + run("synthetic", "bal", "--help").stdout


def test_summary_on_the_console(problem_file: Path, tmp_path: Path) -> None:
    stopped = run("bundle", problem_file, "--max-num-iterations", "1").stdout
    assert "stopped by --max-num-iterations 1" in stopped
    result = run("bundle", problem_file, "-o", tmp_path / "out.npz")
    assert "stopped by" not in result.stdout
    before, after = (
        p.statistics() for p in (read_bal(problem_file), read_npz(tmp_path / "out.npz"))
    )
    assert f"RMSE {before.rmse:.4g} -> {after.rmse:.4g} px" in result.stdout
    assert f"median error {before.median_error:.4g} -> {after.median_error:.4g}" in result.stdout
    assert "behind" not in result.stdout
    problem = read_bal(problem_file)
    problem.points[0] = 100.0 * problem.camera_centers()[0]
    write_npz(problem, tmp_path / "behind.npz")
    shown = run("bundle", tmp_path / "behind.npz", "--max-num-iterations", "0").stdout
    count = problem.statistics().num_behind_camera
    assert count > 0
    assert f"behind their camera {count} -> {count}" in shown


def test_marks_of_steps_that_failed() -> None:
    step = bundle.IterationSummary
    assert not table_row(step(iteration=3, step_is_valid=True, step_is_accepted=True)).endswith("x")
    assert table_row(step(iteration=3, step_is_valid=True, step_is_accepted=False))[-2:] == " x"
    assert table_row(step(iteration=3, step_is_valid=False, step_is_accepted=False))[-2:] == " !"
    assert table_row(step(iteration=0, step_is_accepted=False))[-1].isdigit()


@pytest.mark.parametrize(
    ("arguments", "option"),
    [
        (["--preconditioner", "jacobi"], "--preconditioner"),
        (["--explicit-schur"], "--explicit-schur"),
        (["--max-num-linear-iterations", "9"], "--max-num-linear-iterations"),
        (["--forcing-tolerance", "0.2"], "--forcing-tolerance"),
        (["--fix-intrinsics", "--constant-intrinsics", "0"], "--constant-intrinsics"),
    ],
)
def test_options_without_effect_are_named(
    problem_file: Path, arguments: list[str], option: str
) -> None:
    zero = ["--backend", "ceres", "--max-num-iterations", "0"]
    result = run("bundle", problem_file, *zero, *arguments)
    assert result.exit_code == 0
    assert result.stderr.startswith(f"warning: {option} has no effect")
    assert result.stderr.count("\n") == 1
    assert run("bundle", problem_file, "-q", *zero, *arguments).stderr == ""
    assert run("bundle", problem_file, *zero).stderr == ""


def test_automatic_solver_is_known_to_the_warning() -> None:
    """The limit in the command line is the library's: above it, `auto` is iterative."""
    limit = bundle_command._MAX_CAMERAS_FACTORED
    for num_cameras, kind in ((limit, "SPARSE_SCHUR"), (limit + 1, "ITERATIVE_SCHUR")):
        scene = synthetic.bal(num_cameras=num_cameras, num_points=5000)
        options = bundle.BundleOptions(
            backend=bundle.Backend.CERES, lm=bundle.LmOptions(max_num_iterations=0)
        )
        summary = bundle.adjust(scene.problem, options=options).summary
        assert summary.linear_solver.name == kind


def test_outputs_may_not_overwrite_each_other_or_the_input(
    problem_file: Path, tmp_path: Path
) -> None:
    content = problem_file.read_bytes()
    link = tmp_path / "link.txt"
    link.symlink_to(problem_file)
    refused(run("bundle", problem_file, "-o", problem_file), 2, "the input")
    refused(run("bundle", problem_file, "-o", link), 2, "the input")
    same = tmp_path / "a.ply"
    refused(run("bundle", problem_file, "--ply", same, same), 2, "another output")
    refused(run("bundle", problem_file, "-o", same, "--ply", tmp_path / "b.ply", same), 2, "a.ply")
    refused(run("convert", problem_file, link), 2, "the input")
    refused(
        run("bundle", problem_file, "-o", tmp_path / "r.txt", "--report", tmp_path / "r.txt"), 2
    )
    assert problem_file.read_bytes() == content
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link.txt", "tiny.txt"]


def test_interrupted_while_writing(
    problem_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*args: object, **words: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(viz, "bundle_report", stop)
    output, report = tmp_path / "out.txt", tmp_path / "report"
    result = run("bundle", problem_file, "-o", output, "--report", report)
    refused(result, 130, "not written", str(report / "index.html"))
    assert f"wrote {output}" in result.stdout
    assert str(output) not in result.stderr
    assert output.exists()


def test_bundle_g2o_log(problem_file: Path) -> None:
    result = run("bundle", problem_file, "--log", "g2o")
    expected = bundle.adjust(read_bal(problem_file)).summary.iterations
    lines = [line for line in result.stdout.splitlines() if line.startswith("iteration= ")]
    assert len(lines) == len(expected)
    for line, row in zip(lines, expected, strict=True):
        fields = dict(part.split("= ") for part in line.split("  "))
        assert list(fields) == [
            "iteration", "chi2", "time", "cumTime", "edges", "schur", "lambda", "levenbergIter",
        ]  # fmt: skip
        assert float(fields["chi2"]) == pytest.approx(2 * row["cost"], abs=1e-6)
        assert int(fields["edges"]) == 80


def test_bundle_normalized_solve_comes_back(problem_file: Path, tmp_path: Path) -> None:
    output = tmp_path / "refined.txt"
    assert run("bundle", problem_file, "--normalize", "-q", "-o", output).exit_code == 0
    plain = bundle.adjust(read_bal(problem_file)).problem
    refined = read_bal(output)
    assert refined.cost() == pytest.approx(plain.cost(), rel=1e-4)
    # Same world, not the normalised one, whose points lie about 100 units from their median.
    assert np.abs(refined.points).max() == pytest.approx(np.abs(plain.points).max(), rel=0.2)


def test_bundle_reads_and_writes_npz(problem_file: Path, tmp_path: Path) -> None:
    source = tmp_path / "tiny.npz"
    write_npz(read_bal(problem_file), source)
    assert run("bundle", source, "-q", "-o", tmp_path / "out.npz").exit_code == 0
    assert_close(read_npz(tmp_path / "out.npz"), bundle.adjust(read_bal(problem_file)).problem)


def test_duplicates(tmp_path: Path) -> None:
    problem = make_tiny_problem()
    doubled = problem.replace(
        camera_index=np.append(problem.camera_index, problem.camera_index[:1]),
        point_index=np.append(problem.point_index, problem.point_index[:1]),
        observations=np.vstack([problem.observations, problem.observations[:1]]),
    )
    path = tmp_path / "doubled.txt"
    write_bal(doubled, path)
    refused(run("bundle", path), 1, "doubled.txt")
    assert "81 observations" in run("bundle", path, "--duplicates", "keep").stdout
    assert "80 observations" in run("bundle", path, "--duplicates", "first").stdout
    archive = tmp_path / "doubled.npz"
    refused(run("convert", path, archive), 1, "doubled.txt", "duplicates")
    assert run("convert", path, archive, "--duplicates", "keep").exit_code == 0
    refused(run("bundle", archive), 1, "doubled.npz", "duplicates")
    refused(run("convert", archive, tmp_path / "again.txt"), 1, "doubled.npz")
    assert "81 observations" in run("bundle", archive, "--duplicates", "keep").stdout
    assert "80 observations" in run("bundle", archive, "--duplicates", "mean").stdout


# --- refusals --------------------------------------------------------------------------------


def test_missing_input(tmp_path: Path) -> None:
    refused(run("bundle", tmp_path / "none.txt"), 1, "none.txt")


def test_input_that_is_no_problem(tmp_path: Path) -> None:
    path = tmp_path / "text.txt"
    path.write_text("hello\n")
    refused(run("bundle", path), 1, "text.txt")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--loss", "hubert"], ["hubert"]),
        (["--loss", "huber:-1"], ["-1"]),
        (["--max-num-iterations", "-1"], ["max_num_iterations", "-1"]),
        (["--max-num-iterations", "many"], ["--max-num-iterations"]),
        (["--initial-lambda", "0"], ["initial_lambda"]),
        (["--linear-solver", "magic"], ["magic"]),
        (["--gauge", "loose"], ["loose"]),
        (["--constant-cameras", "0,99"], ["--constant-cameras", "99"]),
        (["--constant-points", ""], ["--constant-points"]),
        (["--constant-cameras", "a-b"], ["a-b"]),
        (["--constant-coordinate", "k2"], ["k2"]),
        (["--constant-coordinate", "pose:0:focal"], ["focal"]),
        (["--constant-coordinate", "pose:99:tx"], ["--constant-coordinate", "99"]),
        (["--no-such-option"], ["--no-such-option"]),
        (["-o", "out.xyz"], ["out.xyz"]),
    ],
)
def test_bad_option_values(problem_file: Path, arguments: list[str], words: list[str]) -> None:
    refused(run("bundle", problem_file, *arguments), 2, *words)


def test_outputs_are_checked_before_the_solve(
    problem_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*args: object, **kwargs: object) -> None:
        raise AssertionError("the solve was started")

    monkeypatch.setattr(bundle, "adjust", never)
    missing = tmp_path / "missing"
    refused(run("bundle", problem_file, "-o", missing / "out.txt"), 1, "missing")
    (tmp_path / "file").touch()
    refused(run("bundle", problem_file, "--report", tmp_path / "file"), 1, "not a folder")
    (tmp_path / "file").unlink()
    folder = tmp_path / "folder.txt"
    folder.mkdir()
    refused(run("bundle", problem_file, "-o", folder), 1, "folder.txt")
    refused(run("bundle", problem_file, "--ply", "a.txt", "b.ply"), 2, "a.txt")
    if Path("/proc/self").exists():  # a folder that takes no files, whatever its mode says
        refused(run("bundle", problem_file, "-o", "/proc/x.txt"), 1, "/proc", "not writable")
    assert sorted(tmp_path.iterdir()) == [folder, problem_file]  # the attempts leave nothing


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_folder(problem_file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o500)
    refused(run("bundle", problem_file, "-o", folder / "out.txt"), 1, "not writable")


def test_failed_solve_writes_nothing(problem_file: Path, tmp_path: Path) -> None:
    problem = read_bal(problem_file)
    problem.cameras[:, 6] = 1e308
    write_npz(problem, tmp_path / "overflow.npz")
    names = set(tmp_path.iterdir())
    output, report = tmp_path / "out.txt", tmp_path / "report"
    refused(run("bundle", tmp_path / "overflow.npz", "-o", output, "--report", report, "-q"), 1)
    assert set(tmp_path.iterdir()) == names


def test_debug_shows_the_traceback(tmp_path: Path) -> None:
    result = run("--debug", "bundle", tmp_path / "none.txt")
    assert result.exit_code == 1
    assert isinstance(result.exception, raylign.FormatError)


def test_parse_indices() -> None:
    assert parse_indices("--o", None, 5) == []
    assert parse_indices("--o", "all", 3) == [0, 1, 2]
    assert parse_indices("--o", "4, 0-2,1", 5) == [0, 1, 2, 4]
    for text in ("", "5", "-1", "2-1", "1-", "x", ",", "0-5"):
        with pytest.raises(raylign.OptionsError, match=r"^--o: "):
            parse_indices("--o", text, 5)


# --- convert, info ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["out.txt", "out.txt.gz", "out.txt.bz2", "out.npz"])
def test_convert_keeps_every_bit(problem_file: Path, tmp_path: Path, name: str) -> None:
    target = tmp_path / name
    result = run("convert", problem_file, target)
    assert result.exit_code == 0, result.output
    read = read_npz if name.endswith(".npz") else read_bal
    assert read(target) == read_bal(problem_file)


def test_convert_to_ply_and_refusals(problem_file: Path, tmp_path: Path) -> None:
    assert run("convert", problem_file, tmp_path / "out.ply", "-q").output == ""
    assert (tmp_path / "out.ply").read_bytes().startswith(b"ply\n")
    far = read_bal(problem_file)
    far.points[0, 0] = 1e6
    write_npz(far, tmp_path / "far.npz")
    shown = run("convert", tmp_path / "far.npz", tmp_path / "far.ply").stdout
    assert shown.endswith("80 observations (1 far points left out)\n")
    refused(run("convert", problem_file, tmp_path / "out.obj"), 2, "out.obj")
    refused(run("convert", tmp_path / "none.txt", tmp_path / "out.txt"), 1, "none.txt")
    refused(run("convert", tmp_path / "out.ply", tmp_path / "again.txt"), 1, "out.ply")


def test_info() -> None:
    facts = json.loads(run("info", "--json").stdout)
    assert facts["raylign"] == raylign.__version__
    assert facts["numpy"] == np.__version__
    for name in ("python", "ceres", "eigen", "compiler", "cpu", "machine"):
        assert facts[name], name
    assert set(facts["blas"]) == {"library", "config"}
    assert "/" not in facts["blas"]["library"]
    assert facts["hardware_threads"] >= 1
    shown = run("info")
    assert shown.exit_code == 0
    assert facts["ceres"] in shown.stdout
