"""The direct bundle adjustment exercise: a second reading and our preset against its log."""

from pathlib import Path

import numpy as np
import pytest

import photometric_oracle as exercise
from raylign import photometric

pytestmark = pytest.mark.data

K = [float(x) for x in (exercise.FX, exercise.FY, exercise.CX, exercise.CY)]

# chi2 and lambda after each step, as printed with image 1 copied over image 0.
PRINTED = [
    (4155163.133872, 370502.930801),
    (4028130.400817, 123500.976934),
    (3929431.366723, 41166.992311),
]


@pytest.fixture(scope="module")
def folder(shared_data: Path) -> Path:
    return shared_data / "direct_ba"


@pytest.fixture(scope="module")
def copied(folder: Path) -> exercise.Exercise:
    return exercise.load(folder, copy_image_1=True)


def test_oracle_follows_the_printed_log(copied):
    assert exercise.cost(copied) == pytest.approx(4430755.95, abs=0.01)
    assert exercise.seen(copied).sum(axis=1).tolist() == [3568, 2935, 2696, 3563, 3891, 3965, 3958]
    steps = exercise.levenberg(copied, len(PRINTED))
    for (_, chi2, damping), (printed, printed_lambda) in zip(steps, PRINTED, strict=True):
        assert chi2 == pytest.approx(printed, abs=0.1)
        assert damping == pytest.approx(printed_lambda, rel=1e-6)


def test_oracle_jacobians_are_those_of_its_projection(copied):
    # The gradient is that of central differences, so the chain rule is checked with g = (1, 0) and
    # (0, 1): the slope of ramps, which central differences give exactly.
    j = 3
    ramps = [
        np.add.outer(np.zeros(480), np.arange(640.0)),
        np.add.outer(np.arange(480.0), np.zeros(640)),
    ]
    for axis, ramp in enumerate(ramps):
        images = [ramp.astype(np.float32)] * 7
        state = exercise.replace(copied, images=images)
        _, u, v = exercise.view(state, j)
        inner = (u > 4) & (v > 4) & (u < 630) & (v < 470)
        J_c, J_p = (J[inner, 0] for J in exercise.jacobians(state, j))
        numeric_c, numeric_p = numeric_jacobians(state, j, axis)
        np.testing.assert_allclose(J_c, -numeric_c[inner], rtol=1e-3, atol=0.05)
        np.testing.assert_allclose(J_p, -numeric_p[inner], rtol=1e-3, atol=0.05)


def numeric_jacobians(state, j: int, axis: int, h: float = 1e-6):
    """Of u or v (axis 0, 1) by central differences in double: (N, 6) and (N, 3)."""
    f = np.array([exercise.FX, exercise.FY], np.float64)[axis]

    def pixel(R, t, X):
        q = X @ R.T + t
        return f * q[:, axis] / q[:, 2]

    columns = []
    for xi in np.eye(6) * h:
        ends = []
        for sign in (1.0, -1.0):
            (dR,), (V,) = exercise.exp(sign * xi[None])
            ends.append(pixel(dR @ state.R[j], dR @ state.t[j] + sign * V @ xi[:3], state.points))
        columns.append((ends[0] - ends[1]) / (2 * h))
    moved = [
        (
            pixel(state.R[j], state.t[j], state.points + d)
            - pixel(state.R[j], state.t[j], state.points - d)
        )
        / (2 * h)
        for d in np.eye(3) * h
    ]
    return np.stack(columns, axis=1), np.stack(moved, axis=1)


def problem(folder: Path, *, copy_image_1: bool) -> photometric.Problem:
    names = [1 if copy_image_1 and i == 0 else i for i in range(7)]
    return photometric.Problem.from_text(
        folder / "points.txt", folder / "poses.txt", [folder / f"{i}.png" for i in names], K
    )


@pytest.mark.slow
def test_preset_follows_the_exercise(folder):
    options, config = photometric.preset("exercise")
    options = options.replace(lm=options.lm.replace(max_num_iterations=100))
    result = photometric.adjust(problem(folder, copy_image_1=True), options=options, config=config)
    start, *steps = result.summary.iterations
    assert 2.0 * start["cost"] == pytest.approx(4430755.95, abs=5.0)
    assert 2.0 * steps[0]["cost"] == pytest.approx(PRINTED[0][0], abs=5.0)
    assert steps[0]["lambda"] == pytest.approx(PRINTED[0][1], abs=0.1)
    for row, (chi2, damping) in zip(steps, PRINTED, strict=False):
        assert 2.0 * row["cost"] == pytest.approx(chi2, rel=1e-5)
        assert row["lambda"] == pytest.approx(damping, rel=1e-6)
    accepted = [row for row in steps if row["step_is_accepted"]]  # one line of the exercise's log
    assert 2.0 * accepted[34]["cost"] <= 3590000.0
    assert not np.array_equal(result.T_cw[0], problem(folder, copy_image_1=True).T_cw[0])


def median_residual(state: exercise.Exercise, brightness: np.ndarray) -> float:
    """Median |c - (e^a I + b)| of the pixels of all patches in view, grey levels."""
    residuals = []
    for j, (a, b) in enumerate(brightness):
        e, inside = exercise.errors(state, j)
        residuals.append(state.patches[inside] - np.exp(a) * (state.patches - e)[inside] - b)
    return float(np.median(np.abs(np.concatenate(residuals))))


@pytest.mark.slow
def test_default_options_do_better_than_the_exercise(folder):
    """Median 7.42 at the start, 6.04 the exercise's way after 35 steps."""
    state = exercise.load(folder, copy_image_1=False)
    assert median_residual(state, np.zeros((7, 2))) == pytest.approx(7.42, abs=0.01)
    result = photometric.adjust(problem(folder, copy_image_1=False))
    assert result.accepted, result.reason
    refined = exercise.replace(
        state, R=result.T_cw[:, :3, :3], t=result.T_cw[:, :3, 3], points=result.points
    )
    assert median_residual(refined, result.brightness) <= 4.9
