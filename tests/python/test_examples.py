"""The examples of docs/theory run, and what the pages claim about them holds.

No claim here is a time: times stand in the pages with their machine. What is tested is counted.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
THEORY = ROOT / "examples" / "theory"
PAGES = ROOT / "docs" / "theory"
FIGURES = {
    "solver_scaling": ["solver-scaling-points", "solver-scaling-cameras"],
    "pose_parametrisations": ["pose-parametrisations"],
    "point_parametrisations": ["point-parametrisations"],
    "graph_structure": ["graph-structure", "fill-in"],
    "modern_synthesis": ["robust-losses", "gauge"],
    "photometric_questions": [
        "photometric-inverse-depth",
        "photometric-patch-size",
        "photometric-features",
        "photometric-threshold",
    ],
}
MAX_FIGURE_BYTES = 150_000

Run = dict[str, Any]


@pytest.fixture(scope="module")
def run_example(tmp_path_factory: pytest.TempPathFactory):
    """Run one example (--quick, or full), once per test module; return its numbers and folder."""
    done: dict[tuple[str, bool], tuple[Run, Path]] = {}

    def run(name: str, *, full: bool = False) -> tuple[Run, Path]:
        if (name, full) not in done:
            folder = tmp_path_factory.mktemp(name)
            numbers = folder / "numbers.json"
            script = [sys.executable, str(THEORY / f"{name}.py"), *([] if full else ["--quick"])]
            result = subprocess.run(
                [*script, "--output", str(folder), "--json", str(numbers)],
                capture_output=True,
                text=True,
                check=False,
            )
            assert result.returncode == 0, result.stderr
            assert result.stdout
            done[name, full] = (json.loads(numbers.read_text(encoding="utf-8")), folder)
        return done[name, full]

    return run


def test_every_example_is_listed():
    assert {p.stem for p in THEORY.glob("*.py")} == {*FIGURES, "common", "photometric_room"}


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_example_draws_its_figures(run_example, name: str):
    _, folder = run_example(name)
    assert {p.stem for p in folder.glob("*.png")} == set(FIGURES[name])


@pytest.mark.parametrize("figure", [f for own in FIGURES.values() for f in own])
def test_figure_is_shipped_and_shown(figure: str):
    image = PAGES / "images" / f"{figure}.png"
    assert 0 < image.stat().st_size < MAX_FIGURE_BYTES
    shown = [p for p in PAGES.glob("*.md") if f"images/{figure}.png" in p.read_text("utf-8")]
    assert shown


def test_no_figure_without_an_example():
    listed = {f for own in FIGURES.values() for f in own}
    assert {p.stem for p in (PAGES / "images").glob("*")} == listed


REFERENCE = re.compile(r"`((?:cpp|python|tests|examples)/[\w./]+\.(?:cpp|h|py))`((?:,? `[^`]+`)*)")


@pytest.mark.parametrize("page", sorted(PAGES.glob("*.md")), ids=lambda p: p.name)
def test_code_that_a_page_names_exists(page: Path):
    """`path` `name`, `name`: the file is there, and each name in it."""
    for path, names in REFERENCE.findall(page.read_text("utf-8")):
        source = (ROOT / path).read_text("utf-8")
        for name in re.findall(r"`([^`]+)`", names):
            if "/" not in name:
                assert name.split("::")[-1] in source, f"{page.name}: {name} is not in {path}"


# --- why bundle adjustment is not slow ---


def by_solver(rows: list[Run], name: str) -> list[Run]:
    return [row for row in rows if row["solver"] == name]


@pytest.mark.slow
def test_direct_solvers_take_the_same_steps(run_example):
    """The Schur complement is no approximation: after three iterations the cost is the same."""
    rows = run_example("solver_scaling")[0]["by_points"]
    dense = [r["final_cost"] for r in by_solver(rows, "DENSE_NORMAL_CHOLESKY")]
    for name in ("DENSE_SCHUR", "SPARSE_SCHUR"):
        assert [r["final_cost"] for r in by_solver(rows, name)] == pytest.approx(dense, rel=1e-9)


@pytest.mark.slow
def test_dense_work_is_cubic_in_points_and_schur_work_is_linear(run_example):
    rows = run_example("solver_scaling")[0]["by_points"]

    def growth(name: str) -> float:
        own = by_solver(rows, name)
        assert own[-1]["points"] == 2 * own[-2]["points"]
        return own[-1]["flops"] / own[-2]["flops"]

    assert (
        growth("DENSE_NORMAL_CHOLESKY") > 5.0
    )  # 8 in the limit; the cameras' columns are constant
    assert growth("DENSE_SCHUR") < 2.0  # 2 in the limit


# --- parametrisations of the pose ---


@pytest.mark.slow
def test_euler_angles_and_angle_axis_lose_a_direction(run_example):
    maps = run_example("pose_parametrisations")[0]["maps"]
    assert maps["euler"][0] == pytest.approx(1.0)
    assert maps["euler"][-1] < 1e-6  # pitch 90°
    assert maps["angle_axis"][0] == pytest.approx(1.0)
    assert maps["angle_axis"][-1] < 1e-6  # angle 360°
    assert all(value > 0.0 for value in maps["angle_axis"][:-1])


@pytest.mark.slow
def test_quaternions_reach_every_direction_and_have_one_number_too_many(run_example):
    maps = run_example("pose_parametrisations")[0]["maps"]
    assert maps["quaternion"] == pytest.approx([1.0] * len(maps["quaternion"]))
    assert maps["quaternion_null"] < 1e-14


@pytest.mark.slow
def test_only_global_three_numbers_suffer_near_a_singularity(run_example):
    rows = run_example("pose_parametrisations")[0]["refinement"]

    def of(kind: str, distance: float, field: str) -> float:
        return next(r[field] for r in rows if (r["kind"], r["distance_deg"]) == (kind, distance))

    for kind in ("quaternion, normalised", "local: exp(φ) R"):
        assert of(kind, 0.01, "worst_decile") == of(kind, 60.0, "worst_decile")
        assert of(kind, 0.01, "failed") == 0.0
    assert of("Euler angles", 0.01, "median") > of("Euler angles", 60.0, "median")
    assert of("angle-axis", 60.0, "failed") == 0.0
    assert of("angle-axis", 0.01, "failed") > 0.1


# --- parametrisations of the point ---


def point_row(run_example, scene: str, kind: str) -> Run:
    rows = run_example("point_parametrisations")[0]["rows"]
    return next(r for r in rows if (r["scene"], r["kind"]) == (scene, kind))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["HOMOGENEOUS", "INVERSE_DEPTH"])
def test_depth_does_not_matter_to_projective_points(run_example, kind: str):
    for scene in ("10", "1000", "1e+06"):
        row = point_row(run_example, scene, kind)
        assert row["excess"] < 1e-9
        assert row["iterations_to_best"] <= 3


@pytest.mark.slow
def test_xyz_needs_many_iterations_far_away_and_never_gets_past_infinity(run_example):
    near, far, beyond = (point_row(run_example, s, "XYZ") for s in ("10", "1000", "1e+06"))
    assert near["excess"] < 1e-9
    assert far["excess"] < 1e-9
    assert far["iterations_to_best"] >= 3 * near["iterations_to_best"]
    assert beyond["iterations_to_best"] is None
    assert beyond["excess"] > 0.01


@pytest.mark.slow
def test_half_of_the_points_at_infinity_end_beyond_it(run_example):
    beyond = run_example("point_parametrisations")[0]["beyond_infinity"]
    assert beyond["10"] == 0.0
    assert 0.3 < beyond["1e+06"] < 0.7


@pytest.mark.slow
def test_xyz_stops_above_the_others_when_everything_is_free(run_example):
    xyz = point_row(run_example, "all free", "XYZ")
    assert xyz["excess"] > 0.01
    for kind in ("HOMOGENEOUS", "INVERSE_DEPTH"):
        assert point_row(run_example, "all free", kind)["excess"] < 1e-3


# --- the graph ---


@pytest.mark.slow
def test_reduced_matrix_couples_cameras_that_share_a_point(run_example):
    small = run_example("graph_structure")[0]["small"]
    assert small["S_equals_shared"]
    rows, columns = small["J_shape"]
    assert small["J_density"] == pytest.approx(12 / columns)  # nine of a camera, three of a point
    assert rows == 180


@pytest.mark.slow
def test_ordering_reduces_fill_in_and_a_street_is_sparser_than_an_orbit(run_example):
    rows = run_example("graph_structure")[0]["rows"]
    blocks = {(r["kind"], r["order"]): r["blocks_L"] / r["full"] for r in rows}
    assert blocks["street", "minimum degree"] < blocks["street", "given"]
    assert blocks["street", "minimum degree"] < blocks["orbit", "minimum degree"]
    for row in rows:
        assert row["blocks_S"] <= row["blocks_L"] <= row["full"]


# --- robust losses and gauge ---


@pytest.mark.slow
def test_robust_losses_keep_the_cameras_where_least_squares_loses_them(run_example):
    rows = run_example("modern_synthesis")[0]["outliers"]
    error = {(r["loss"], r["outliers"]): r["error_m"] for r in rows}
    for loss in ("huber:1", "cauchy:1", "student_t:1:5"):
        assert error["trivial", 0.1] > 5.0 * error[loss, 0.1]
    assert error["cauchy:1", 0.1] < 2.0 * error["cauchy:1", 0.0]


@pytest.mark.slow
def test_gauges_reach_the_same_cost_with_fewer_unknowns(run_example):
    gauge = run_example("modern_synthesis")[0]["gauge"]
    free, first, two = gauge["rows"]
    assert free["unknowns"] - first["unknowns"] == 6
    assert free["unknowns"] - two["unknowns"] == 7
    assert first["final_cost"] == pytest.approx(free["final_cost"], rel=1e-9)
    assert two["final_cost"] == pytest.approx(free["final_cost"], rel=1e-9)
    assert gauge["null_space"] == 7


@pytest.mark.slow
def test_covariance_depends_on_the_gauge(run_example):
    gauge = run_example("modern_synthesis")[0]["gauge"]
    assert gauge["sigma_first"][0] == 0.0
    assert min(gauge["sigma_free"]) > 0.0
    assert max(gauge["sigma_free"]) < max(gauge["sigma_first"])
    assert gauge["prediction_difference"] < 1e-6  # of 1 px²: predictions do not depend on it
