"""Errors against a known truth."""

import numpy as np
import pytest

from raylign import ShapeError, evaluate, geometry
from raylign.scene import BalProblem


def test_a_similarity_is_no_error(tiny_problem: BalProblem) -> None:
    S_nw = geometry.sim3_exp(np.array([1.0, -2.0, 0.5, 0.3, -0.4, 1.1, 0.7]))
    moved = tiny_problem.transformed(S_nw)
    assert np.abs(moved.camera_centers() - tiny_problem.camera_centers()).max() > 1.0
    np.testing.assert_allclose(evaluate.camera_center_errors(moved, tiny_problem), 0.0, atol=1e-12)


def test_a_moved_camera_is_an_error_in_units_of_the_truth(tiny_problem: BalProblem) -> None:
    scaled = tiny_problem.transformed(np.diag([10.0, 10.0, 10.0, 1.0]))
    scaled.cameras[2, 5] += 1.0  # 0.1 in the truth's units
    errors = evaluate.camera_center_errors(scaled, tiny_problem)
    assert errors.shape == (4,)
    assert 0.01 < np.linalg.norm(errors) <= 0.1  # the alignment may take some of it away


def test_different_numbers_of_cameras(tiny_problem: BalProblem) -> None:
    fewer = tiny_problem.replace(
        cameras=tiny_problem.cameras[:3].copy(),
        camera_index=tiny_problem.camera_index[:1],
        point_index=tiny_problem.point_index[:1],
        observations=tiny_problem.observations[:1],
    )
    with pytest.raises(ShapeError, match="3 cameras against 4"):
        evaluate.camera_center_errors(fewer, tiny_problem)
