"""RGB-D odometry on rendered sequences: right where it says so, honest where it is not."""

import itertools

import numpy as np
import pytest

from raylign import OptionsError, ShapeError, geometry, odometry, synthetic, trajectory
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.odometry import (
    MotionModelOptions,
    OdometryOptions,
    OdometryStatus,
    RgbdOdometry,
    ShutterOptions,
)
from raylign.trajectory import Trajectory

WIDTH, HEIGHT = 160, 120
CAMERA = PinholeCamera(130.0, 130.0, 79.5, 59.5)


def frames_of(n=14, seed=0, camera=CAMERA, motion="handheld", scene=None):
    _, T_wc = synthetic.trajectory(motion, n=n, seed=seed)
    scene = scene or synthetic.room(seed=seed)
    return list(
        synthetic.render_sequence(scene, camera, T_wc, width=WIDTH, height=HEIGHT, seed=seed)
    ), T_wc


@pytest.fixture(scope="module")
def sequence():
    return frames_of()


class Stamped:
    """A frame at another time."""

    def __init__(self, frame, timestamp):
        self.image, self.depth, self.timestamp = frame.truth.image, frame.depth, timestamp


def stamped(frames):
    return [Stamped(frame, i / 30.0) for i, frame in enumerate(frames)]


def error_of(run, T_wc, timestamps):
    truth = Trajectory(timestamps, T_wc)
    result = trajectory.evaluate(run.trajectory, truth, alignment=trajectory.Alignment.FIRST_POSE)
    return result.absolute.translation.rmse


def test_follows_a_handheld_camera(sequence):
    frames, T_wc = sequence
    seen = []
    run = odometry.run(stamped(frames), CAMERA, T_wc=T_wc[0], callback=seen.append)
    assert [r.status for r in run.results] == [OdometryStatus.OK] * len(frames)
    assert len(seen) == len(frames) == len(run.times_s)
    assert run.results[0].is_keyframe
    assert run.keyframes[0] == 0
    np.testing.assert_array_equal(run.results[0].T_wc, T_wc[0])
    assert error_of(run, T_wc, np.arange(len(frames)) / 30.0) < 0.01
    assert not run.was_interrupted
    assert run.num_lost == 0


def rolling(readout_time, n=20, fps=15.0):
    # fast enough that rows of one image differ by degrees
    timestamps, T_wc = synthetic.trajectory("handheld", n=n, extent=0.4, angle_deg=25.0, fps=fps)
    options = synthetic.RenderOptions(readout_time=readout_time)
    T_cw = geometry.se3_inverse(T_wc)
    frames = []
    for i, pose in enumerate(T_cw):
        twist = 0.5 * geometry.se3_log(T_cw[min(i + 1, n - 1)] @ T_wc[max(i - 1, 0)])
        frame = synthetic.render(
            synthetic.boxes(seed=1), CAMERA, pose, width=WIDTH, height=HEIGHT, options=options,
            sensor=synthetic.SensorOptions(read_noise=1.0), motion=twist, seed=1, index=i,
        )  # fmt: skip
        frames.append((frame.image, synthetic.sense_depth(frame, CAMERA, seed=1, index=i)))
    return frames, T_wc, timestamps


def follow(frames, timestamps, options, camera=CAMERA):
    tracker = RgbdOdometry(camera, options=options)
    return [
        tracker.track(image, depth, timestamp=float(t))
        for (image, depth), t in zip(frames, timestamps, strict=True)
    ]


def errors_to_keyframe(results, T_wc):
    errors = []
    for r in results[1:]:
        T_th = geometry.se3_inverse(T_wc[r.frame]) @ T_wc[r.keyframe]
        errors.append(np.linalg.norm((r.alignment.T_th @ np.linalg.inv(T_th))[:3, 3]))
    return np.array(errors)


@pytest.mark.parametrize("with_depth", [False, True])
def test_finds_the_readout_time_of_a_rolling_shutter(with_depth):
    frames, T_wc, timestamps = rolling(0.8)
    options = OdometryOptions()
    depth_term = options.tracking.depth.replace(enabled=with_depth)
    options = options.replace(tracking=options.tracking.replace(depth=depth_term))
    found = follow(frames, timestamps, options)
    assert all(r.status is OdometryStatus.OK for r in found)
    assert found[-1].readout_s == pytest.approx(0.8 / 15.0, rel=0.25)
    held = options.replace(shutter=ShutterOptions(estimate_readout=False))
    rigid = errors_to_keyframe(follow(frames, timestamps, held), T_wc)
    assert errors_to_keyframe(found, T_wc).max() < 0.6 * rigid.max()


def test_a_global_shutter_has_no_readout_time():
    frames, _, timestamps = rolling(0.0)
    results = follow(frames, timestamps, OdometryOptions())
    assert abs(results[-1].readout_s) < 0.05 / 15.0


def passing_board(n=20, fps=30.0):
    camera, size = PinholeCamera(262.5, 262.5, 159.5, 119.5), {"width": 320, "height": 240}
    _, T_wc = synthetic.trajectory("handheld", n=60, extent=0.4, angle_deg=20.0, fps=fps, seed=1)
    frames = []
    for i in range(n):
        board = synthetic.board(seed=1, offset=(-0.7 + 2.4 * i / 59, 0.0), size=(0.5, 0.8))
        frame = synthetic.render(
            synthetic.boxes(seed=1) + board, camera, geometry.se3_inverse(T_wc[i]), **size,
            sensor=synthetic.SensorOptions(read_noise=1.0), seed=1, index=i,
        )  # fmt: skip
        frames.append((frame.image, synthetic.sense_depth(frame, camera, seed=1, index=i)))
    return frames, T_wc, np.arange(n) / fps, camera


def test_intensities_alone_do_not_follow_a_passing_board():
    frames, T_wc, timestamps, camera = passing_board()
    options = OdometryOptions()
    no_depth_term = options.tracking.depth.replace(enabled=False)
    options = options.replace(tracking=options.tracking.replace(depth=no_depth_term))
    held = errors_to_keyframe(follow(frames, timestamps, options, camera), T_wc)
    free = options.replace(max_depth_step=10.0)
    followed = errors_to_keyframe(follow(frames, timestamps, free, camera), T_wc)
    assert held.max() < 0.05
    assert followed.max() > 0.05


def test_same_bits_for_any_number_of_threads(sequence):
    frames, _ = sequence
    poses = []
    for threads in (1, 2):
        options = OdometryOptions()
        tracking = options.tracking
        tracking = tracking.replace(lm=tracking.lm.replace(num_threads=threads))
        run = odometry.run(stamped(frames), CAMERA, options=options.replace(tracking=tracking))
        poses.append(run.trajectory.T_wc)
    np.testing.assert_array_equal(*poses)


@pytest.mark.parametrize("constant_velocity", [True, False])
def test_a_foreign_frame_is_lost_and_the_next_one_recovered(sequence, constant_velocity):
    frames, T_wc = sequence
    motion = MotionModelOptions(constant_velocity=constant_velocity)
    other, _ = frames_of(n=2, seed=5, scene=synthetic.boxes(seed=77))
    mixed = stamped([*frames[:6], *other, *frames[6:]])
    run = odometry.run(mixed, CAMERA, T_wc=T_wc[0], options=OdometryOptions(motion=motion))
    statuses = [r.status for r in run.results]
    assert statuses[6:8] == [OdometryStatus.LOST] * 2
    assert statuses[8] is OdometryStatus.RECOVERED
    assert all(np.isnan(r.T_wc).all() and r.reason for r in run.results[6:8])
    assert run.num_lost == 2
    kept = np.r_[0:6, 8 : len(mixed)]
    truth = Trajectory(kept / 30.0, T_wc)
    result = trajectory.evaluate(run.trajectory, truth, alignment=trajectory.Alignment.FIRST_POSE)
    assert result.absolute.translation.max < 0.02


def test_a_teleported_camera_is_not_believed(sequence):
    """The second frame shows the scene from far away: right, or honestly not OK."""
    _, T_wc = sequence
    far = geometry.se3_exp([1.2, 0.0, 0.3, 0.0, 0.9, 0.0])
    poses = np.stack([T_wc[0], T_wc[0] @ far])
    jump = list(
        synthetic.render_sequence(synthetic.room(seed=0), CAMERA, poses, width=WIDTH, height=HEIGHT)
    )
    run = odometry.run(stamped(jump), CAMERA, T_wc=T_wc[0])
    result = run.results[1]
    if result.status is OdometryStatus.OK:
        np.testing.assert_allclose(result.T_wc, poses[1], atol=0.02)
    else:
        assert result.reason


def test_starts_with_the_first_frame_that_has_depth(sequence):
    frames, _ = sequence
    late = stamped(frames)
    late[0].depth = None
    late[1].depth = np.full((HEIGHT, WIDTH), np.nan, np.float32)
    run = odometry.run(late, CAMERA)
    statuses = [r.status for r in run.results]
    assert statuses[:2] == [OdometryStatus.NO_DEPTH] * 2
    assert statuses[2:] == [OdometryStatus.OK] * (len(frames) - 2)
    assert run.results[2].keyframe == 2


def test_distortion_is_removed_before_tracking():
    camera = RadtanCamera(130.0, 130.0, 79.5, 59.5, -0.15, 0.03, 0.001, -0.001)
    frames, T_wc = frames_of(n=8, camera=camera)
    run = odometry.run(stamped(frames), camera, T_wc=T_wc[0])
    assert run.num_lost == 0
    assert run.camera.fx > camera.fx * 0.9
    assert error_of(run, T_wc, np.arange(8) / 30.0) < 0.01
    ignored = odometry.run(stamped(frames), PinholeCamera(130.0, 130.0, 79.5, 59.5), T_wc=T_wc[0])
    assert error_of(run, T_wc, np.arange(8) / 30.0) < error_of(ignored, T_wc, np.arange(8) / 30.0)


def test_millimetres_and_metres_are_the_same(sequence):
    frames, _ = sequence
    in_mm = stamped(frames[:4])
    for frame in in_mm:
        depth = np.nan_to_num(frame.depth)
        frame.depth = np.round(depth * 1000).astype(np.uint16)
    rounded = stamped(frames[:4])
    for frame, other in zip(rounded, in_mm, strict=True):
        frame.depth = (other.depth / 1000).astype(np.float32)
    a, b = (odometry.run(frames_, CAMERA).trajectory.T_wc for frames_ in (in_mm, rounded))
    np.testing.assert_allclose(a, b, atol=1e-5)


def test_callback_and_ctrl_c_keep_what_there_is(sequence):
    frames, _ = sequence
    count = itertools.count(1)
    run = odometry.run(stamped(frames), CAMERA, callback=lambda _: next(count) < 5)
    assert run.was_interrupted
    assert len(run.results) == len(run.times_s) == 5

    def interrupt(result):
        if result.frame == 3:
            raise KeyboardInterrupt

    run = odometry.run(stamped(frames), CAMERA, callback=interrupt)
    assert run.was_interrupted
    assert len(run.results) == len(run.times_s) == 4


def test_wrong_input_is_refused(sequence):
    frames, _ = sequence
    tracker = RgbdOdometry(CAMERA)
    tracker.track(frames[0].truth.image, frames[0].depth, timestamp=1.0)
    with pytest.raises(OptionsError, match="timestamp must be"):
        tracker.track(frames[1].truth.image, frames[1].depth, timestamp=1.0)
    with pytest.raises(
        ShapeError, match=r"image must have the size of the first image, \(120, 160"
    ):
        tracker.track(frames[1].truth.image[:100], frames[1].depth[:100], timestamp=2.0)
    with pytest.raises(ShapeError, match="depth must have the size"):
        tracker.track(frames[1].truth.image, frames[1].depth[:, :80].copy(), timestamp=2.0)
    with pytest.raises(ShapeError, match="T_wc must be"):
        RgbdOdometry(CAMERA, T_wc=np.eye(4)[None])
    after = tracker.track(frames[1].truth.image, frames[1].depth, timestamp=2.0)
    assert after.status is OdometryStatus.OK, "refused frames leave no trace"


@pytest.mark.parametrize(
    ("field", "value"),
    [("depth_scale", 0.0), ("num_recovery_keyframes", 0), ("depth_scale", float("nan"))],
)
def test_options_are_checked(field, value):
    with pytest.raises(OptionsError, match=field):
        OdometryOptions(**{field: value})


def test_sim3_is_refused():
    from raylign.tracking import MotionGroup

    options = OdometryOptions()
    with pytest.raises(OptionsError, match="SE3 or SO3"):
        options.replace(tracking=options.tracking.replace(motion=MotionGroup.SIM3))
