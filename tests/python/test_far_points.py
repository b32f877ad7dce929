"""Landmarks far away, at infinity and beyond it: homogeneous points converge where XYZ stalls.

Six cameras on a line of length 1 look at landmarks that all start at 5 baselines on the true ray
(docs/theory/parametrisations.md). At 10⁶ baselines the disparity is far below the noise, so the
best inverse depth of about every second landmark is negative: w passes zero.
"""

import numpy as np
import pytest

from raylign import bundle
from raylign.bundle import Backend, BundleConfig, BundleOptions, Gauge, LmOptions
from raylign.scene import BalProblem

NUM_CAMERAS, NUM_POINTS = 6, 100
LM = LmOptions(max_num_iterations=40, function_tolerance=1e-12)


def make_problem(*, far: float) -> BalProblem:
    """Every third landmark at 10 baselines, the others at `far`; 0.1 px of noise."""
    rng = np.random.default_rng(4)
    cameras = np.zeros((NUM_CAMERAS, 9))
    cameras[:, 3] = -np.linspace(-0.5, 0.5, NUM_CAMERAS)
    cameras[:, 4] = rng.normal(0.0, 0.05, NUM_CAMERAS)
    cameras[:, 6] = 500.0
    rays = np.column_stack([rng.uniform(-0.5, 0.5, (NUM_POINTS, 2)), -np.ones(NUM_POINTS)])
    depth = np.where(np.arange(NUM_POINTS) % 3 == 0, 10.0, far)
    camera_index, point_index = np.divmod(np.arange(NUM_CAMERAS * NUM_POINTS), NUM_POINTS)
    p_c = (rays * depth[:, None])[point_index] + cameras[camera_index, 3:6]
    pixels = -500.0 * p_c[:, :2] / p_c[:, 2:]
    return BalProblem(
        cameras,
        5.0 * rays,
        camera_index.astype(np.int32),
        point_index.astype(np.int32),
        pixels + rng.normal(0.0, 0.1, pixels.shape),
    )


def solve(
    problem: BalProblem,
    point: str,
    backend: Backend,
    config: BundleConfig,
    parity: bool = False,
):
    options = BundleOptions(backend=backend, point_parametrization=point, lm=LM, parity=parity)
    return bundle.adjust(problem, config=config, options=options)


def iterations_to(costs: np.ndarray, target: float) -> int:
    """Index of the first row at or below the target; the number of rows when there is none."""
    return int(np.argmax(np.append(costs, -np.inf) <= target))


CONFIGS = {
    "points": BundleConfig(
        constant_cameras=range(NUM_CAMERAS), constant_intrinsics=range(NUM_CAMERAS)
    ),
    "poses too": BundleConfig(gauge=Gauge.TWO_CAMERAS, constant_intrinsics=range(NUM_CAMERAS)),
}


@pytest.mark.parametrize("backend", [Backend.CERES, Backend.NATIVE], ids=lambda b: b.name)
@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_homogeneous_converges_where_xyz_stalls(backend, config):
    problem = make_problem(far=1e6)
    best = solve(problem, "inverse_depth", Backend.CERES, config).summary.final_cost
    homogeneous = solve(problem, "homogeneous", backend, config)
    xyz = solve(problem, "xyz", backend, config)
    assert homogeneous.summary.final_cost == pytest.approx(best, rel=1e-6)
    assert iterations_to(homogeneous.summary.iterations["cost"], 1.001 * best) <= 8
    assert xyz.summary.final_cost > 1.002 * best  # 40 iterations later
    # beyond infinity: what XYZ cannot reach
    behind = homogeneous.problem.depths()[homogeneous.problem.camera_index == 0] < 0.0
    assert 0.1 * NUM_POINTS < np.count_nonzero(behind) < 0.6 * NUM_POINTS
    assert xyz.problem.depths().min() > 0.0
    assert homogeneous.problem.cost() == pytest.approx(homogeneous.summary.final_cost, rel=1e-6)


@pytest.mark.parametrize("far", [1e3, 1e6, 1e9])
@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_both_engines_walk_the_same_path_to_infinity(config, far):
    problem = make_problem(far=far)
    native, ceres = (
        solve(problem, "homogeneous", backend, config, parity=True).summary.iterations["cost"]
        for backend in (Backend.NATIVE, Backend.CERES)
    )
    count = min(len(native), len(ceres), 11)
    assert count >= 3
    np.testing.assert_allclose(native[:count], ceres[:count], rtol=1e-8)


def test_a_start_at_and_beyond_infinity_is_an_ordinary_start():
    """Points written 10¹² extents away, in front of and behind the cameras, come back in place."""
    problem = make_problem(far=10.0)
    config = CONFIGS["points"]
    expected = solve(problem, "homogeneous", Backend.NATIVE, config)
    far = problem.copy()
    far.points[::4] *= 1e12
    far.points[1::4] *= -1e6
    found = solve(far, "homogeneous", Backend.NATIVE, config)
    assert found.summary.final_cost == pytest.approx(expected.summary.final_cost, rel=1e-9)
    np.testing.assert_allclose(found.problem.points, expected.problem.points, rtol=1e-4)
