"""The benchmarks' own arithmetic: a wrong judge would make every published number wrong."""

import math
import struct
from pathlib import Path

import numpy as np
import pytest

import raylign

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture(autouse=True)
def _harness_on_the_path(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))


@pytest.fixture
def written(tiny_problem, tmp_path):
    """The tiny problem as the judge reads it from its file."""
    from harness import judge

    raylign.io.write_bal(tiny_problem, tmp_path / "tiny.txt")
    return judge.read_problem(tmp_path / "tiny.txt")


def test_judge_and_raylign_agree_on_the_cost(tiny_problem, written):
    from harness import judge

    expected = raylign.bundle.linearize(tiny_problem).cost
    assert judge.cost(written, written.cameras, written.points) == pytest.approx(expected, 1e-12)


def test_judge_counts_what_lies_behind_a_camera(written):
    from harness import judge

    behind = written.points.copy()
    behind[0] = [0.0, 0.1, 30.0]  # the cameras stand near z = 6 and look along −z
    moved = judge.Problem(
        written.cameras, behind, written.camera_index, written.point_index, written.pixels
    )
    assert np.count_nonzero(judge.depths(moved) < 0.0) == 4
    assert judge.cost(moved, moved.cameras, behind) > judge.cost(
        written, written.cameras, written.points
    )


def test_time_to_a_cost_is_the_first_time():
    from harness import judge

    trace = [[0.1, 100.0], [0.2, 20.0], [0.3, 20.0], [0.5, 10.0]]
    goals = judge.targets(100.0, 10.0)
    np.testing.assert_allclose(goals, [19.0, 10.9, 10.09, 10.009, 10.01])
    assert judge.time_to(trace, 100.0) == 0.1
    assert judge.time_to(trace, 20.0) == 0.2
    assert judge.time_to(trace, goals[0]) == 0.5
    assert judge.time_to(trace, 9.0) == math.inf


def test_rate_leaves_preprocessing_out():
    from harness import judge

    run = {"trace": [[5.0, 3.0], [6.0, 2.0], [7.0, 1.0]]}
    assert judge.ns_per_observation_and_iteration(run, 1000) == pytest.approx(1e6)


def contest(*turns: dict[str, float]) -> dict:
    """A contest in which system `key` takes `seconds` to the optimum, NaN: it failed."""
    runs = []
    for number, turn in enumerate(turns):
        for key, seconds in turn.items():
            run = {"round": number, "system": key, "trace": [[0.0, 9.0], [seconds, 1.0]]}
            run |= dict.fromkeys(("parse_s", "build_s", "preprocess_s", "solve_s"), 0.0)
            run |= {"judged_cost": 1.0, "baseline_bytes": 0, "peak_bytes": 500}
            run |= {"message": "CONVERGENCE: Function tolerance reached."}
            failed = {"round": number, "system": key, "error": "killed"}
            runs.append(failed if math.isnan(seconds) else run)
    sizes = {"num_cameras": 2, "num_points": 3, "num_observations": 10}
    return {"problem": "p", **sizes, "initial_cost": 9.0, "measured": [], "runs": runs}


def test_ratios_are_taken_within_a_round():
    from harness import contest as contests

    # The machine slows down tenfold in the last round; the ratio of medians would be 1.
    held = contests.summarize(contest({"a": 4.0, "b": 1.0}, {"a": 8.0, "b": 2.0}, {"b": 40.0}))
    assert contests.ratio(held, "a", "b", contests.headline_time) == 4.0
    assert contests.ratio(held, "a", "absent", contests.headline_time) is None


def test_a_failure_is_a_row_and_never_a_time():
    from harness import contest as contests

    held = contests.summarize(contest({"a": math.nan, "b": 1.0}, {"a": math.nan, "b": 3.0}))
    failed, row = held["rows"]
    assert failed == {"system": "a", "error": "killed"}
    assert row["times_to"][-1] == 2.0
    assert row["memory_bytes_per_observation"] == 50.0


def test_merged_rounds_stay_apart():
    from harness import contest as contests

    first = contest({"a": 4.0, "b": 1.0})
    held = contests.summarize(contests.merge(first, contest({"a": 80.0, "b": 20.0})))
    assert [run["round"] for run in held["runs"]] == [0, 0, 1, 1]
    assert contests.ratio(held, "a", "b", contests.headline_time) == 4.0


def test_colmap_model_holds_the_same_problem(written, tmp_path):
    from harness import colmap_model

    colmap_model.write_model(written, tmp_path)
    points = (tmp_path / "points3D.bin").read_bytes()
    num_points, first_id, x = struct.unpack_from("<QQd", points)
    assert (num_points, first_id, x) == (20, 1, written.points[0, 0])
    record = 8 + 24 + 3 + 8 + 8 + 4 * 8  # the cameras see every point
    assert len(points) == 8 + num_points * record
    track = np.frombuffer(points, "<u4", 8, 8 + 5 * record + 51).reshape(4, 2)
    np.testing.assert_array_equal(track, [[1, 5], [2, 5], [3, 5], [4, 5]])
    assert len((tmp_path / "images.bin").read_bytes()) == 8 + 4 * (64 + 7 + 8 + 20 * 24)


def test_colmap_rotations_are_a_half_turn_from_ours(written):
    from harness import colmap_model

    w = written.cameras[:, :3]
    real, x, y, z = colmap_model.quaternions(w).T
    R = raylign.geometry.quaternion_to_matrix(np.stack([x, y, z, real], axis=1))
    expected = np.diag([1.0, -1.0, -1.0]) @ raylign.geometry.so3_exp(w)
    np.testing.assert_allclose(R, expected, atol=1e-14)


def test_what_failed_once_is_not_tried_again_in_its_contest(written, tmp_path, monkeypatch):
    from harness import contest as contests
    from harness import problems, systems

    monkeypatch.setattr(systems, "CACHE", tmp_path)
    spec = problems.find_spec("orbit-50-1000")
    monkeypatch.setattr(systems, "command", lambda system, *_: [system.solver, "argument"])
    told: list[str] = []
    held = {"measured": [{"rounds": 3}], "runs": []}
    chosen = [systems.System("gone", "/no/such/program", 1), systems.System("mute", "true", 1)]
    tools = systems.Tools(tmp_path, None)
    contests.hold(held, written, spec, chosen, tools, told.append)
    assert len(told) == 6
    assert [run["system"] for run in held["runs"]] == [system.key for system in chosen]
    assert "FileNotFoundError" in held["runs"][0]["error"]
    assert "IndexError" in held["runs"][1]["error"]  # exit status 0, but no JSON


def test_ends_are_named_alike_for_every_system():
    from harness import contest as contests

    messages = {
        "CONVERGENCE: Function tolerance reached. |cost change| / cost: 2e-09": "tolerance",
        "MAX_ITERATIONS: max_num_iterations reached": "limit of iterations",
        "TIME_LIMIT: max_solver_time_s reached": "time limit",
        "Ceres 2.1.0: Maximum number of iterations reached. Number of iterations: 9.": (
            "limit of iterations"
        ),
        "pycolmap 4, Ceres 2: Maximum solver time reached. Total solver time: 1": "time limit",
        "GTSAM 4.3.0: time limit, 0 restarts with more damping": "time limit",
        "FAILURE: Trust region radius too small": "",
    }
    assert {text: contests.end_of({"message": text}) for text in messages} == messages


def test_session_keeps_what_was_measured_and_appends(tmp_path):
    import json

    from harness.session import Session, fresh_target

    target = tmp_path / "r.json"
    session = Session(target, {"commit": "1"}, append=False)
    assert not session.save()
    assert not target.exists()
    session.contests.append(contest({"a": 4.0}))
    session.contests.append({**contest(), "problem": "interrupted"})
    assert session.save()
    again = Session(target, {"commit": "2"}, append=True)
    again.contests.append(contest({"a": 6.0}))
    again.parts["import"] = {"python": 0.1}
    again.save()
    results = json.loads(target.read_text())["results"]
    assert [run["round"] for run in results["contests"][0]["runs"]] == [0, 1]
    assert len(results["contests"]) == 1
    assert results["import"] == {"python": 0.1}
    (tmp_path / "2026-01-02.json").touch()
    assert fresh_target(tmp_path, "2026-01-02").name == "2026-01-02-2.json"


def test_tables_say_why_a_system_has_no_figure():
    import report
    from harness import contest as contests

    held = contest({"native auto x1": 1.0, "autodiff dense x1": 8.0, "gtsam schur x1": math.nan})
    slow = {**held["runs"][1], "system": "pycolmap auto x1"}
    slow |= {"trace": [[0.0, 9.0], [5.0, 2.0]], "judged_cost": 2.0}
    slow |= {"message": "pycolmap 4.2.1: Maximum solver time reached."}
    held["runs"] += [slow, {**held["runs"][1], "system": "analytic dense x1", "judged_cost": 1.5}]
    held["measured"] = [
        {"commit": "c", "date": "d", "rounds": 1, "max_iterations": 9, "time_limit_s": 60.0}
    ]
    table = report.headline_table([contests.summarize(held)], 1)
    row = table.splitlines()[2]
    assert row == "| p | 1 | 8.0 / 8.0 / 1.0 | 8.0 / 8.0 / 1.0\\* | not in 60 s | failed |"
    assert "pycolmap 4.2.1" in table.splitlines()[0]
    assert report.headline_table([contests.summarize(held)], 2).startswith("No peer")
    section = report.contest_sections([contests.summarize(held)])
    assert "gtsam schur x1 failed: killed" in section
    assert "at most 9 iterations or 60 s" in section


def test_cache_has_no_halves(tmp_path, monkeypatch):
    from harness import problems

    monkeypatch.setattr(problems, "CACHE", tmp_path)

    def interrupted(path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        problems.cached("scene.txt", interrupted)
    made = problems.cached("scene.txt", lambda path: path.write_text("whole"))
    assert made.read_text() == "whole"
    assert problems.cached("scene.txt", interrupted) == made


def test_a_contest_that_fails_leaves_the_others(tmp_path, monkeypatch):
    import io

    from rich.console import Console

    import run
    from harness import contest as contests
    from harness import systems
    from harness.session import Session

    def prepare(spec, facts, rounds):
        if spec.name == "street-50-1000":
            raise ValueError("a broken file")
        return contest({"native auto x1": 1.0}), None

    monkeypatch.setattr(contests, "prepare", prepare)
    monkeypatch.setattr(contests, "hold", lambda *_: None)
    monkeypatch.setattr("sys.argv", ["run.py", "--problems", "street-50-1000", "orbit-50-1000"])
    session = Session(tmp_path / "r.json", {}, append=False)
    console = Console(file=io.StringIO(), width=200)
    run.hold_contests(run.parse_arguments(), systems.Tools(tmp_path, None), session, console)
    assert session.errors == {"street-50-1000": "ValueError: a broken file"}
    assert "p: 2 cameras" in console.file.getvalue()
    assert session.target.exists()
