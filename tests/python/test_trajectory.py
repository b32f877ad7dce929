"""Trajectories: the class, association in time, alignment, and errors against evo and by hand."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import raylign
from raylign import geometry, trajectory
from raylign.trajectory import Alignment, Trajectory, associate, estimate_time_offset, match


def wandering(num_poses: int = 120, seed: int = 0, rate: float = 30.0) -> Trajectory:
    """A smooth path with all six degrees of freedom, about 4 m long in 4 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(num_poses) / rate
    phase = rng.uniform(0, 2 * np.pi, 6)
    speed = rng.uniform(0.5, 2.0, 6)
    curves = np.sin(t[:, None] * speed + phase)
    q = Rotation.from_rotvec(0.6 * curves[:, 3:]).as_quat()
    return Trajectory.from_quaternions(1e9 + t, curves[:, :3], q)


def perturbed(truth: Trajectory, seed: int = 1, sigma: float = 0.01) -> Trajectory:
    """Independent errors on every pose, sigma in m and rad."""
    xi = np.random.default_rng(seed).normal(0.0, sigma, (len(truth), 6))
    return Trajectory(truth.timestamps, truth.T_wc @ geometry.se3_exp(xi))


def straight(num_poses: int = 30) -> Trajectory:
    t = np.arange(num_poses, dtype=float)
    positions = np.column_stack([t, np.zeros_like(t), np.zeros_like(t)])
    return Trajectory.from_quaternions(t, positions, np.tile([0.0, 0.0, 0.0, 1.0], (num_poses, 1)))


# --- the class -----------------------------------------------------------------------------------


def test_arrays_are_copied_and_read_only():
    stamps, T_wc = np.arange(3.0), np.tile(np.eye(4), (3, 1, 1))
    path = Trajectory(stamps, T_wc)
    stamps[0] = 7.0
    assert path.timestamps[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        path.T_wc[0, 0, 3] = 1.0


def test_slices_masks_and_equality():
    path = wandering(10)
    assert path[2:8:2] == Trajectory(path.timestamps[2:8:2], path.T_wc[2:8:2])
    assert len(path[path.timestamps > path.timestamps[4]]) == 5
    stamp, T_wc = path[-1]
    assert stamp == path.timestamps[-1]
    np.testing.assert_array_equal(T_wc, path.T_wc[-1])
    assert path != path[:-1]
    assert path.__eq__(3) is NotImplemented
    with pytest.raises(raylign.OptionsError, match="increasing"):
        path[::-1]


@pytest.mark.parametrize(
    ("stamps", "change", "error", "message"),
    [
        ([0.0, 1.0], None, raylign.ShapeError, "timestamps must be"),
        ([0.0, 1.0, 1.0], None, raylign.OptionsError, "strictly increasing, got 1.0"),
        ([0.0, 2.0, 1.0], None, raylign.OptionsError, "index 2"),
        ([0.0, np.nan, 1.0], None, raylign.OptionsError, "finite"),
        ([0.0, 1.0, 2.0], (1, 0, 3, np.inf), raylign.OptionsError, "finite"),
        ([0.0, 1.0, 2.0], (1, 0, 0, 1.1), raylign.OptionsError, "pose 1"),
        ([0.0, 1.0, 2.0], (2, 0, 0, -1.0), raylign.OptionsError, "pose 2"),
        ([0.0, 1.0, 2.0], (0, 3, 3, 2.0), raylign.OptionsError, "pose 0"),
        ("abc", None, raylign.ShapeError, "real numbers"),
    ],
)
def test_bad_trajectories_are_refused(stamps, change, error, message):
    T_wc = np.tile(np.eye(4), (3, 1, 1))
    if change is not None:
        T_wc[change[:3]] = change[3]
    with pytest.raises(error, match=message):
        Trajectory(stamps, T_wc)


def test_empty_trajectory():
    empty = Trajectory([], np.zeros((0, 4, 4)))
    assert len(empty) == 0
    assert empty.path_length() == empty.duration_s() == empty.median_period_s() == 0.0
    assert "empty" in repr(empty)
    assert len(empty.interpolate([1.0])) == 0


def test_interpolation_is_exact_on_a_screw_motion():
    """Constant velocity and constant angular velocity: the poses in between are known."""
    t = np.linspace(0.0, 2.0, 9)
    omega = np.array([0.3, -0.2, 0.9])

    def poses(times):
        q = Rotation.from_rotvec(times[:, None] * omega).as_quat()
        return Trajectory.from_quaternions(times, times[:, None] * [1.0, 2.0, 3.0], q)

    between = np.sort(np.random.default_rng(0).uniform(0.0, 2.0, 40))
    result = poses(t).interpolate(between)
    np.testing.assert_allclose(result.T_wc, poses(between).T_wc, atol=1e-14)
    np.testing.assert_array_equal(poses(t).interpolate(t).T_wc[:, :3, 3], poses(t).positions)


def test_interpolation_leaves_out_what_it_cannot_know():
    path = wandering(10, rate=1.0)[[0, 1, 2, 6, 7]]
    t0 = path.timestamps[0]
    result = path.interpolate(t0 + np.array([-0.5, 0.5, 4.0, 6.0, 6.5, 7.5]), max_gap_s=1.5)
    np.testing.assert_allclose(result.timestamps - t0, [0.5, 6.0, 6.5])


# --- association ---------------------------------------------------------------------------------


def brute_force(a: np.ndarray, b: np.ndarray, limit: float) -> tuple[int, float]:
    """Most pairs, then least sum, over every monotone one-to-one pairing."""
    best = (0, 0.0)
    for size in range(1, min(len(a), len(b)) + 1):
        for rows in itertools.combinations(range(len(a)), size):
            for columns in itertools.combinations(range(len(b)), size):
                gap = abs(a[list(rows)] - b[list(columns)])
                if (gap <= limit).all():
                    best = max(best, (size, -float(gap.sum())))
    return best


@pytest.mark.parametrize("seed", range(25))
def test_association_is_the_best_there_is(seed: int):
    rng = np.random.default_rng(seed)
    a, b = (np.sort(rng.uniform(0, 1, rng.integers(1, 7))) for _ in range(2))
    limit = rng.uniform(0.05, 0.5)
    pairs = associate(a, b, max_difference_s=limit)
    gap = abs(a[pairs[:, 0]] - b[pairs[:, 1]])
    count, negative_sum = brute_force(a, b, limit)
    assert (np.diff(pairs, axis=0) > 0).all()
    assert len(pairs) == count
    assert gap.sum() == pytest.approx(-negative_sum, abs=1e-12)


def test_association_does_not_reuse_a_stamp_half_a_period_away():
    """The pattern of TUM fr1, on which the nearest stamp alternates and repeats."""
    color = 1.3e9 + np.arange(40) / 30 + np.random.default_rng(0).uniform(-2e-3, 2e-3, 40)
    depth = 1.3e9 + np.arange(41) / 30 - 0.0165
    nearest = abs(color[:, None] - depth).argmin(axis=1)
    assert len(set(nearest)) < len(nearest)
    offset = estimate_time_offset(color, depth)
    assert abs(offset) == pytest.approx(0.0165, abs=2e-3)
    pairs = associate(color, depth, offset_s=offset)
    assert len(pairs) == 40
    assert len(set(pairs[:, 1] - pairs[:, 0])) == 1
    other = estimate_time_offset(color, depth, near_s=-offset)
    assert np.sign(other) == -np.sign(offset)


def test_offset_of_nothing_in_common_is_where_it_started():
    assert estimate_time_offset([0.0, 1.0], [100.0, 101.0], near_s=0.25) == 0.25
    assert estimate_time_offset([0.0], [0.01]) == 0.0


@pytest.mark.parametrize(
    "arguments",
    [
        {"first": [1.0, 0.0]},
        {"first": [0.0, np.nan]},
        {"max_difference_s": 0.0},
        {"max_difference_s": np.inf},
        {"offset_s": np.nan},
    ],
)
def test_bad_associations_are_refused(arguments):
    with pytest.raises(raylign.OptionsError, match="associate"):
        associate(**{"first": [0.0], "second": [0.0], **arguments})
    with pytest.raises(raylign.ShapeError, match="second"):
        associate([0.0], [[0.0]])


def test_match_by_interpolation_removes_the_error_of_the_stamps():
    truth = wandering(400, rate=100.0)
    times = truth.timestamps[0] + 0.004 + np.arange(90) / 30
    estimate = truth.interpolate(times)
    nearest = trajectory.ate(*match(estimate, truth)).translation.rmse
    exact = trajectory.ate(*match(estimate, truth, interpolate=True)).translation.rmse
    assert nearest > 1e-3
    assert exact < 1e-12


# --- errors against the truth --------------------------------------------------------------------


@pytest.mark.parametrize("mode", [Alignment.SE3, Alignment.SIM3, Alignment.FIRST_POSE])
def test_errors_do_not_depend_on_the_world(mode: Alignment):
    """ATE and RPE are invariant to any rigid transform of the estimate; with SIM3 to any scale."""
    truth = wandering()
    estimate = perturbed(truth)
    base = trajectory.evaluate(estimate, truth, alignment=mode)
    rng = np.random.default_rng(5)
    for _ in range(5):
        sigma = rng.normal(0.0, 0.5) if mode is Alignment.SIM3 else 0.0
        S = geometry.sim3_exp(np.append(rng.normal(0.0, 2.0, 6), sigma))
        moved = trajectory.evaluate(estimate.transformed(S), truth, alignment=mode)
        for name in ("absolute", "per_frame", "per_second"):
            for part in ("translation", "rotation"):
                expected = getattr(getattr(base, name), part).values
                got = getattr(getattr(moved, name), part).values
                np.testing.assert_allclose(got, expected, atol=1e-9)


@pytest.mark.parametrize("mode", [Alignment.SE3, Alignment.SIM3])
def test_alignment_recovers_the_transform(mode: Alignment):
    truth = wandering()
    scale = 0.4 if mode is Alignment.SIM3 else 0.0
    S_te = geometry.sim3_exp([1.0, -2.0, 3.0, 0.4, 0.5, -0.6, scale])
    estimate = truth.transformed(geometry.sim3_inverse(S_te))
    result = trajectory.evaluate(estimate, truth, alignment=mode)
    np.testing.assert_allclose(result.absolute.S_te, S_te, atol=1e-10)
    assert result.scale == pytest.approx(np.exp(scale), abs=1e-12)
    assert result.absolute.translation.max < 1e-10
    assert result.absolute.rotation.max < 1e-7
    assert result.per_frame.translation.max < 1e-10


def test_statistics_by_hand():
    """Offsets of 3 and 4 m on two of four poses: nothing is aligned away."""
    truth = wandering(4)
    T_wc = truth.T_wc.copy()
    T_wc[1, 0, 3] += 3.0
    T_wc[3, 1, 3] -= 4.0
    result = trajectory.ate(Trajectory(truth.timestamps, T_wc), truth, mode=Alignment.NONE)
    np.testing.assert_allclose(result.translation.values, [0.0, 3.0, 0.0, 4.0], atol=1e-15)
    assert result.translation.rmse == pytest.approx(2.5)
    assert result.translation.mean == pytest.approx(1.75)
    assert result.translation.median == pytest.approx(1.5)
    assert result.translation.max == pytest.approx(4.0)
    assert result.rotation.max == 0.0


@pytest.mark.parametrize("mode", [Alignment.SE3, Alignment.SIM3])
def test_positions_on_a_line_are_a_clear_error(mode: Alignment):
    with pytest.raises(raylign.Error, match="on one line or in one place"):
        trajectory.ate(straight(), straight(), mode=mode)
    still = Trajectory(np.arange(5.0), np.tile(np.eye(4), (5, 1, 1)))
    with pytest.raises(raylign.Error, match="on one line or in one place"):
        trajectory.ate(still, still, mode=mode)
    assert trajectory.ate(still, still, mode=Alignment.FIRST_POSE).translation.max == 0.0
    with pytest.raises(raylign.ShapeError, match="at least 3 poses, got 2"):
        trajectory.ate(still[:2], still[:2], mode=mode)


def test_lengths_that_differ_are_refused():
    path = wandering(5)
    for function in (trajectory.align, trajectory.ate, trajectory.rpe, trajectory.segment_errors):
        with pytest.raises(raylign.ShapeError, match="5 poses against 4"):
            function(path, path[:4])
        with pytest.raises(raylign.ShapeError, match="at least one"):
            function(path[:0], path[:0])


def test_rpe_per_second_spans_a_second_and_no_gap():
    truth = wandering(120)
    gap = np.ones(120, bool)
    gap[50:70] = False
    pairs = trajectory.rpe(truth[gap], truth[gap], delta_s=1.0).pairs
    t = truth.timestamps[gap]
    span = t[pairs[:, 1]] - t[pairs[:, 0]]
    assert abs(span - 1.0).max() <= 0.5 / 30 + 1e-6
    assert len(pairs) > 40
    assert len(trajectory.rpe(truth[:20], truth[:20], delta_s=1.0).pairs) == 0
    with pytest.raises(raylign.OptionsError, match="not both"):
        trajectory.rpe(truth, truth, delta_s=1.0, delta_frames=1)
    with pytest.raises(raylign.OptionsError, match="delta_frames"):
        trajectory.rpe(truth, truth, delta_frames=0)


def test_segments_of_a_known_drift():
    """1 % too long and 0.001 rad per m of yaw: every segment shows just that."""
    s = np.arange(0.0, 1000.5, 1.0)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (len(s), 1))
    positions = np.column_stack([s, 0 * s, 0 * s])
    truth = Trajectory.from_quaternions(s, positions, level)
    stretched = Trajectory.from_quaternions(s, 1.01 * positions, level)
    rows = trajectory.segment_errors(stretched, truth)
    assert [row.length for row in rows] == list(trajectory.KITTI_LENGTHS_M)
    for row in rows:
        assert row.translation == pytest.approx(0.01 * (row.length + 1.0) / row.length)
        assert row.rotation == 0.0
    # Starts every 10 poses with the end inside; a segment ends at the first pose beyond it.
    assert [row.num_segments for row in rows] == [90, 80, 70, 60, 50, 40, 30, 20]
    yaw = Rotation.from_rotvec(np.outer(0.001 * s, [0.0, 0.0, 1.0])).as_quat()
    turned = Trajectory.from_quaternions(s, positions, yaw)
    assert trajectory.segment_errors(turned, truth)[0].rotation == pytest.approx(0.00101)
    assert trajectory.segment_errors(truth[:50], truth[:50]) == []
    lengths = trajectory.short_lengths(truth[:101])
    assert lengths == pytest.approx([10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0])
    assert len(trajectory.segment_errors(truth[:101], truth[:101], lengths=lengths)) == 8
    with pytest.raises(raylign.OptionsError, match="lengths"):
        trajectory.segment_errors(truth, truth, lengths=[0.0])


def test_coverage_is_a_share_of_the_truth():
    truth = wandering(400, rate=100.0)
    estimate = truth[::3]
    assert trajectory.coverage(estimate, truth) == 1.0
    assert trajectory.coverage(estimate[:67], truth) == pytest.approx(0.5, abs=0.01)
    assert trajectory.coverage(truth[::10], truth) == pytest.approx(1.0, abs=0.02)
    assert trajectory.coverage(estimate.shifted(100.0), truth) == 0.0
    assert trajectory.coverage(estimate.shifted(100.0), truth, offset_s=-100.0) == 1.0
    assert trajectory.coverage(truth[:0], truth) == 0.0


def test_stamps_in_another_unit_are_a_clear_error():
    truth = wandering()
    nanoseconds = Trajectory(truth.timestamps * 1e9, truth.T_wc)
    with pytest.raises(raylign.Error, match="unit of the stamps"):
        trajectory.evaluate(nanoseconds, truth)


# --- evo -----------------------------------------------------------------------------------------


def evo_path(path: Trajectory):
    from evo.core.trajectory import PoseTrajectory3D  # an oracle: GPL, run and never copied

    return PoseTrajectory3D(
        positions_xyz=path.positions.copy(),
        orientations_quat_wxyz=np.roll(path.quaternions, 1, axis=1),
        timestamps=path.timestamps.copy(),
    )


def compare(ours: trajectory.ErrorStatistics, metric) -> None:
    for name in ("rmse", "mean", "median", "max"):
        assert getattr(ours, name) == pytest.approx(metric.get_all_statistics()[name], abs=1e-9)


@pytest.mark.parametrize("mode", [Alignment.NONE, Alignment.SE3, Alignment.SIM3])
@pytest.mark.parametrize("sigma", [1e-3, 0.1])
def test_agrees_with_evo(mode: Alignment, sigma: float):
    metrics = pytest.importorskip("evo.core.metrics")
    truth = wandering()
    S = geometry.sim3_exp([0.1, 0.2, 0.3, 0.1, -0.2, 0.3, 0.2 if mode is Alignment.SIM3 else 0.0])
    estimate = perturbed(truth, sigma=sigma).transformed(S)
    ours = trajectory.evaluate(estimate, truth, alignment=mode)
    reference, aligned = evo_path(truth), evo_path(estimate)
    if mode is not Alignment.NONE:
        aligned.align(reference, correct_scale=mode is Alignment.SIM3)
    relations = metrics.PoseRelation
    for ours_part, relation in (
        (ours.absolute.translation, relations.translation_part),
        (ours.absolute.rotation, relations.rotation_angle_rad),
    ):
        ape = metrics.APE(relation)
        ape.process_data((reference, aligned))
        compare(ours_part, ape)
    for ours_part, relation in (
        (ours.per_frame.translation, relations.translation_part),
        (ours.per_frame.rotation, relations.rotation_angle_rad),
    ):
        relative = metrics.RPE(relation, delta=1, delta_unit=metrics.Unit.frames)
        relative.process_data((reference, aligned))
        compare(ours_part, relative)
    per_second = metrics.RPE(  # 30 Hz: a second is 30 frames
        relations.translation_part, delta=30, delta_unit=metrics.Unit.frames, all_pairs=True
    )
    per_second.process_data((reference, aligned))
    compare(ours.per_second.translation, per_second)


def test_golden_numbers():
    """What evo 1.38.1 gave for this input, for machines without it."""
    truth = wandering()
    ours = trajectory.evaluate(perturbed(truth), truth)
    found = [
        ours.absolute.translation.rmse,
        ours.absolute.rotation.rmse,
        ours.per_frame.translation.rmse,
        ours.per_frame.rotation.rmse,
        ours.per_second.translation.rmse,
    ]
    expected = [
        0.016349876743030352,
        0.0172635781201117,
        0.02381063940013765,
        0.024409874372206066,
        0.031144206436254554,
    ]
    assert found == pytest.approx(expected, abs=1e-9)
