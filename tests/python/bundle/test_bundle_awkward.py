"""raylign.bundle.adjust: degenerate, broken and duplicate input."""

import numpy as np
import pytest

import oracle
import raylign
from bundle_cases import POINTS, subproblem
from raylign.bundle import BundleOptions, Termination


@pytest.mark.parametrize(
    "make",
    [
        lambda p: np.zeros(80, bool),
        lambda p: np.arange(80) == 0,
        lambda p: p.camera_index == 0,
        lambda p: p.point_index == 0,
        lambda p: p.camera_index < 2,
    ],
    ids=["empty", "one observation", "one camera", "one point", "two cameras"],
)
@pytest.mark.parametrize(("backend", "point"), POINTS, ids=lambda p: p.name)
def test_degenerate_problems_give_a_finite_answer(adjust, perturbed, make, point):
    keep = make(perturbed)
    problem = subproblem(perturbed, keep)
    result = adjust(problem, options=BundleOptions(point_parametrization=point))
    assert result.summary.is_usable()
    assert result.summary.final_cost <= result.summary.initial_cost
    assert np.all(np.isfinite(result.problem.cameras))
    assert np.all(np.isfinite(result.problem.points))
    unseen_points = np.setdiff1d(np.arange(20), problem.point_index)
    np.testing.assert_array_equal(
        result.problem.points[unseen_points], problem.points[unseen_points]
    )


def test_duplicate_observations_count_twice(adjust, tiny_problem):
    twice = subproblem(tiny_problem, np.r_[np.arange(80), 7])
    extra = 0.5 * np.sum(oracle.residuals(tiny_problem)[7] ** 2)
    summary = adjust(twice).summary
    assert summary.initial_cost == pytest.approx(oracle.cost(tiny_problem) + extra, rel=1e-12)
    assert summary.is_usable()


@pytest.mark.parametrize("where", ["points", "cameras", "observations"])
def test_nan_at_the_start_is_a_failure_that_names_the_observation(adjust, tiny_problem, where):
    getattr(tiny_problem, where)[2, 0] = np.nan
    before = tiny_problem.copy()
    result = adjust(tiny_problem)
    assert result.summary.termination is Termination.FAILURE
    assert not result.summary.is_usable()
    first = np.flatnonzero(~np.isfinite(oracle.residuals(tiny_problem)).all(axis=1))[0]
    assert f"observation {first} " in result.summary.message
    assert result.problem == before


def test_point_in_the_camera_plane_is_a_failure(adjust, tiny_problem):
    centers = tiny_problem.camera_centers()
    tiny_problem.points[4] = centers[0]
    summary = adjust(tiny_problem).summary
    assert summary.termination is Termination.FAILURE
    assert "point 4" in summary.message


def test_views_with_a_broken_index_are_refused(adjust, tiny_problem):
    tiny_problem.camera_index[3] = 99
    with pytest.raises(raylign.ShapeError, match="camera_index"):
        adjust(tiny_problem)
