"""The command line as a process of its own: Ctrl-C, pipes, imports."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from raylign.io import read_bal, write_bal
from tiny_problem import make_tiny_problem

COMMAND = [sys.executable, "-c", "from raylign.cli import main; main()"]
ENVIRONMENT = {**os.environ, "COLUMNS": "200", "PYTHONUNBUFFERED": "1"}


@pytest.fixture
def problem_file(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.txt"
    write_bal(make_tiny_problem(), path)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_keeps_the_best_state(
    problem_file: Path, tmp_path: Path, number: signal.Signals
) -> None:
    output, report = tmp_path / "out.txt", tmp_path / "report"
    # Tolerances of zero: the solve ends only by the signal.
    arguments = [
        "bundle", str(problem_file), "-o", str(output), "--report", str(report),
        "--max-num-iterations", "2000000000", "--function-tolerance", "0",
        "--gradient-tolerance", "0", "--parameter-tolerance", "0", "--loss", "cauchy:0.1",
    ]  # fmt: skip
    with subprocess.Popen(
        COMMAND + arguments,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
    ) as process:
        assert process.stdout is not None
        rows = 0
        for line in process.stdout:
            rows += line.split()[:1] == [str(rows)]
            if rows == 3:
                break
        process.send_signal(number)
        stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert "Traceback" not in stderr
    assert "best state" in stdout
    record = json.loads((report / "summary.json").read_text())
    assert record["summary"]["termination"] == "user_stopped"
    assert record["summary"]["final_cost"] <= record["summary"]["initial_cost"]
    assert read_bal(output).num_points == 20
    assert len(list(report.glob("*.png"))) == 4


def test_errors_go_to_stderr(tmp_path: Path) -> None:
    done = subprocess.run(
        [*COMMAND, "bundle", str(tmp_path / "none.txt")],
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
        check=False,
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1


def test_closed_pipe_is_no_accident(problem_file: Path) -> None:
    with subprocess.Popen(
        [*COMMAND, "bundle", str(problem_file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert "Traceback" not in process.stderr.read()


def test_heavy_modules_are_imported_by_the_commands_that_need_them() -> None:
    code = (
        "import sys, raylign.cli\n"
        "heavy = ('matplotlib', 'pooch', 'requests', 'cv2', 'scipy')\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
