"""Numbers and formulas that the pages of docs/theory and README.md print are what the code gives.

Tables of counts are read from the pages and compared; times stand in the pages with their machine.
"""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import raylign
from raylign.bundle import BundleConfig, BundleOptions, LmOptions, adjust, linearize
from raylign.evaluate import camera_center_errors
from raylign.robust import Loss

sys.path.insert(0, str(Path(__file__).parent))
from test_examples import run_example  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "docs" / "theory"


def table(page: str, first_heading: str) -> list[list[str]]:
    """Cells of each row below the heading that begins with `first_heading`."""
    lines = (PAGES / page).read_text("utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {first_heading} |"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def integer(cell: str) -> int:
    return int(re.sub(r"\s", "", cell))


@pytest.mark.slow
def test_table_of_fill_in_is_the_script_s(run_example):  # noqa: F811
    rows = run_example("graph_structure", full=True)[0]["rows"]
    printed = table("graph-structure.md", "scene")
    assert len(printed) == len(rows)
    for cells, row in zip(printed, rows, strict=True):
        assert cells[0].startswith(row["kind"])
        assert (cells[1] == "minimum degree") == (row["order"] == "minimum degree")
        assert [integer(c) for c in cells[2:4]] == [row["blocks_S"], row["blocks_L"]]
        new, full = 1.0 - row["blocks_S"] / row["blocks_L"], row["blocks_L"] / row["full"]
        assert cells[4:] == [f"{100 * new:.0f} %", f"{100 * full:.0f} %"]


@pytest.mark.slow
def test_table_of_points_is_the_script_s(run_example):  # noqa: F811
    result = run_example("point_parametrisations", full=True)[0]
    scenes: dict[str, list[dict[str, Any]]] = {}
    for row in result["rows"]:
        scenes.setdefault(row["scene"], []).append(row)
    printed = table("parametrisations.md", "landmarks at")
    assert len(printed) == len(scenes)
    for cells, rows in zip(printed, scenes.values(), strict=True):
        for cell, row in zip(cells[1:], rows, strict=True):
            if row["iterations_to_best"] is not None:
                assert int(cell) == row["iterations_to_best"]
            else:
                assert cell.startswith("never")
                assert f"{100 * row['excess']:.1f} % above" in cell
    share = f"At 10⁶ baselines {100 * result['beyond_infinity']['1e+06']:.0f} % of the landmarks"
    assert share in (PAGES / "parametrisations.md").read_text("utf-8")


@pytest.mark.parametrize(
    ("heading", "scene"),
    [
        ("points", lambda n: {"kind": "orbit", "num_cameras": 8, "num_points": n}),
        ("cameras", lambda n: {"kind": "street", "num_cameras": n, "num_points": 40 * n}),
    ],
)
def test_observations_of_the_timed_problems(heading: str, scene):
    rows = table("why-bundle-adjustment-is-not-slow.md", heading)
    sizes = [(integer(row[0]), integer(row[1])) for row in rows if row[0][0].isdigit()]
    assert len(sizes) >= 6
    for size, observations in sizes:
        if observations < 40_000:  # the larger ones take seconds
            problem = raylign.synthetic.bal(seed=2, **scene(size)).problem
            assert problem.num_observations == observations


@pytest.mark.data
@pytest.mark.slow
@pytest.mark.parametrize("row", [0, 1, 2], ids=["xyz", "homogeneous", "inverse_depth"])
def test_gauges_on_ladybug_are_as_printed(shared_data: Path, row: int):
    path = shared_data / "bal" / "problem-49-7776-pre.txt"
    if not path.is_file():
        pytest.skip(f"{path.name} not found")
    problem = raylign.io.read_bal(path)
    name, *costs = table("modern-synthesis.md", "points")[row]
    kind = name.upper().replace(" ", "_")
    options = BundleOptions(
        point_parametrization=raylign.bundle.PointParametrization[kind],
        lm=LmOptions(max_num_iterations=100),
        parity=True,
    )
    page = (PAGES / "parametrisations.md").read_text("utf-8")
    cost, iterations = re.search(rf"--point {kind.lower()} +# ([\d ]+) after +(\d+)", page).groups()
    free = adjust(problem, options=options.replace(lm=LmOptions())).summary
    assert free.final_cost == pytest.approx(integer(cost), abs=0.5)
    assert abs(len(free.iterations) - 1 - int(iterations)) <= 2
    for gauge, cell in zip(raylign.bundle.Gauge, costs, strict=True):
        summary = adjust(problem, config=BundleConfig(gauge=gauge), options=options).summary
        assert summary.final_cost == pytest.approx(float(cell.replace(" ", "")), rel=1e-5)


def dense(linear) -> np.ndarray:
    J = np.zeros((len(linear.residuals), linear.num_columns))
    rows = np.repeat(np.arange(len(J)), np.diff(linear.row_starts))
    J[rows, linear.columns] = linear.values
    return J


def small_problem():
    return raylign.synthetic.bal(num_cameras=6, num_points=40, seed=5).problem


def test_robust_rows_are_scaled_by_the_root_of_the_weight():
    problem = small_problem()
    plain = linearize(problem)
    robust = linearize(problem, options=BundleOptions(loss=Loss.parse("cauchy:1")))
    squared = np.sum(plain.residuals.reshape(-1, 2) ** 2, axis=1)
    root = np.repeat(np.sqrt(Loss.parse("cauchy:1").evaluate(squared)[1]), 2)
    assert root.min() < 0.5
    np.testing.assert_allclose(robust.residuals, root * plain.residuals, rtol=1e-12)
    np.testing.assert_allclose(dense(robust), root[:, None] * dense(plain), rtol=1e-9, atol=1e-9)


def test_sphere_plus_jacobian_is_half_of_a_householder_matrix():
    """∂r/∂δ = (ℓ J_P R, J_P (R c + t)) ½ (H_1 H_2 H_3), from the Jacobian of the XYZ points."""
    problem = small_problem()
    kind = raylign.bundle.PointParametrization.HOMOGENEOUS
    homogeneous = dense(linearize(problem, options=BundleOptions(point_parametrization=kind)))
    xyz = dense(linearize(problem))
    centres = problem.camera_centers()
    c = centres.mean(axis=0)
    extent = np.sqrt(np.mean(np.sum((centres - c) ** 2, axis=1)))
    for j, X in enumerate(problem.points):
        columns = slice(9 * 6 + 3 * j, 9 * 6 + 3 * j + 3)
        J_X = xyz[:, columns]
        sphere = np.append((X - c) / extent, 1.0)
        sphere /= np.linalg.norm(sphere)
        # J_P is of degree −1 in P, and J_P P = 0 turns R c + t into R (c − X)
        J = np.column_stack([extent * J_X, J_X @ (c - X)]) / sphere[3]
        v = sphere - [0.0, 0.0, 0.0, 1.0]
        H = np.eye(4) - 2.0 * np.outer(v, v) / (v @ v)
        np.testing.assert_allclose(
            homogeneous[:, columns], 0.5 * J @ H[:, :3], rtol=1e-7, atol=1e-6
        )


# --- photometric bundle adjustment ---


def test_the_exercise_misprints_two_entries_of_the_pose_jacobian():
    """∂(u, v)/∂ξ of photometric.md is the derivative; the printed column 6 is not."""
    fx, fy = 277.34, 291.402
    x, y, z = q = np.array([0.4, -0.3, 1.7])

    def project(xi: np.ndarray) -> np.ndarray:
        p = raylign.geometry.se3_exp(xi) @ np.append(q, 1.0)
        return np.array([fx * p[0] / p[2], fy * p[1] / p[2]])

    h = 1e-5 * np.eye(6)
    numeric = np.column_stack([(project(e) - project(-e)) / 2e-5 for e in h])
    right = np.array(
        [
            [fx / z, 0, -fx * x / z**2, -fx * x * y / z**2, fx * (1 + x**2 / z**2), -fx * y / z],
            [0, fy / z, -fy * y / z**2, -fy * (1 + y**2 / z**2), fy * x * y / z**2, fy * x / z],
        ]
    )
    np.testing.assert_allclose(right, numeric, atol=1e-6)
    printed = np.array([-fy * y / z, fy * x * y / z])
    assert (np.abs(printed - numeric[:, 5]) > 1.0).all()


@pytest.mark.slow
def test_answers_on_photometric_adjustment_are_the_script_s(run_example):  # noqa: F811
    numbers = run_example("photometric_questions")[0]
    far = numbers["depths"][1]
    assert abs(far["asymmetry_rho"]) < 0.1 < far["asymmetry_z"]
    error = {row["pattern"]: row["error_px"] for row in numbers["patterns"]}
    assert error["custom"] > error["3x3"] > error["4x4"] > error["5x5"]
    by_start = {row["start_px"]: row for row in numbers["basin"]}
    assert by_start[6.0]["four_levels"] < by_start[6.0]["features"]
    assert by_start[20.0]["features"] < 1.0 < by_start[20.0]["one_level"]
    clean, spoilt = numbers["threshold"]
    assert spoilt["student_t"] < spoilt["huber"]
    assert spoilt["5"] > 2.0 * clean["5"]
    assert spoilt["nu"] < 4.0 < clean["nu"]


# --- the front page ---


def center_rms(problem, truth) -> float:
    return float(np.sqrt(np.mean(camera_center_errors(problem, truth) ** 2)))


def test_readme_example_brings_the_cameras_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    readme = (ROOT / "README.md").read_text("utf-8")
    block = re.search(r"^```python\n(.*?)^```$", readme, re.DOTALL | re.MULTILINE)
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(compile(block[1], "README.md", "exec"), names)
    before, after = (
        center_rms(p, names["truth"]) for p in (names["problem"], names["result"].problem)
    )
    assert before > 0.5
    assert after < 0.05
    assert readme.count("cauchy:1.0") == 3  # Python, C++, command line
    assert "huber" not in readme


def test_first_example_brings_the_cameras_home(tmp_path: Path):
    script = [sys.executable, str(ROOT / "examples" / "01_bal.py"), "--out", str(tmp_path)]
    output = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    before, after = re.search(r"off by (\S+) m before, (\S+) m after", output).groups()
    assert float(after) < 0.2 * float(before)


@pytest.mark.slow
def test_an_example_without_output_leaves_the_repository_alone(tmp_path: Path):
    shipped = {p: p.stat().st_mtime_ns for p in (PAGES / "images").iterdir()}
    script = [sys.executable, str(ROOT / "examples" / "theory" / "graph_structure.py"), "--quick"]
    output = subprocess.run(
        script,
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"TMPDIR": str(tmp_path)},
    ).stdout
    assert {p: p.stat().st_mtime_ns for p in (PAGES / "images").iterdir()} == shipped
    assert {p.name for p in tmp_path.rglob("*.png")} == {"graph-structure.png", "fill-in.png"}
    assert str(tmp_path) in output
