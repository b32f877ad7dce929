"""What the tests of raylign.bundle share: engines, what each can do, tight tolerances."""

import pytest

import raylign
from raylign.bundle import Backend, LmOptions, PointParametrization

TIGHT = LmOptions(
    max_num_iterations=200,
    function_tolerance=1e-14,
    gradient_tolerance=1e-14,
    parameter_tolerance=1e-14,
)

BACKENDS = [Backend.CERES, Backend.NATIVE]
POINTS = [  # what each engine can do
    (Backend.CERES, PointParametrization.XYZ),
    (Backend.CERES, PointParametrization.HOMOGENEOUS),
    (Backend.CERES, PointParametrization.INVERSE_DEPTH),
    (Backend.NATIVE, PointParametrization.XYZ),
    (Backend.NATIVE, PointParametrization.HOMOGENEOUS),
]

ceres_only = pytest.mark.parametrize("backend", [Backend.CERES], ids=["CERES"])


def subproblem(problem, keep):
    """The same cameras and points with only some observations."""
    return raylign.BalProblem(
        problem.cameras.copy(),
        problem.points.copy(),
        problem.camera_index[keep].copy(),
        problem.point_index[keep].copy(),
        problem.observations[keep].copy(),
    )
