"""Rendered sequences that nothing was tuned on: does an OK ever hide a run-away?"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from raylign import geometry, synthetic
from raylign.camera import PinholeCamera
from raylign.odometry import OdometryOptions, OdometryResult, RgbdOdometry, has_pose
from raylign.synthetic import RenderOptions, SensorOptions
from tracking import frames

CAMERA = PinholeCamera(262.5, 262.5, 159.5, 119.5)
WIDTH, HEIGHT = 320, 240
NUM_FRAMES = 60
# An OK beyond this, between the frame and its keyframe, is a run-away: 2 % of the mean depth of
# these rooms (about 2.5 m), and as much in angle
BOUND_M, BOUND_DEG = 0.05, 1.2
NOISE = SensorOptions(read_noise=1.0, shot_noise=0.02)


@dataclass(frozen=True)
class Case:
    """How a sequence is rendered; what is not said is a quiet handheld camera in a room."""

    motion: str = "handheld"
    extent: float = 0.4
    angle_deg: float = 20.0
    fps: float = 30.0
    scene: str = "boxes"
    brightness: str = "constant"
    render: RenderOptions = field(default_factory=RenderOptions)
    read_noise: float = 1.0
    moving_board: bool = False
    jump: bool = False


CASES = {
    "handheld": Case(),
    "handheld, fast (10 fps)": Case(fps=10.0),
    "handheld, very fast (5 fps)": Case(fps=5.0),
    "turn, 1.5°/frame": Case(motion="rotation", angle_deg=90.0),
    "turn, 4°/frame": Case(motion="rotation", angle_deg=240.0),
    "turn, 8°/frame": Case(motion="rotation", angle_deg=480.0),
    "forward, 3 cm/frame": Case(motion="z", extent=1.8, scene="room"),
    "exposure drifts, ×0.5 to ×1.6": Case(brightness="drift"),
    "exposure jumps, ×0.6 and ×1.5": Case(brightness="jumps"),
    "motion blur, half a frame": Case(
        fps=15.0, render=RenderOptions(exposure_time=0.5, blur_samples=8)
    ),
    "rolling shutter": Case(fps=15.0, render=RenderOptions(readout_time=0.9)),
    "noise of 8 grey values": Case(read_noise=8.0),
    "occluder passes": Case(moving_board=True),
    "camera jumps by 40°": Case(jump=True),
    "long baseline plane": Case(scene="plane", extent=0.8),
}  # fmt: skip


def trajectory_of(case: Case, seed: int) -> np.ndarray:
    _, T_wc = synthetic.trajectory(
        case.motion, n=NUM_FRAMES, extent=case.extent, angle_deg=case.angle_deg, fps=case.fps,
        seed=seed,
    )  # fmt: skip
    if case.jump:
        turn = geometry.se3_exp(np.array([0, 0, 0, 0, np.deg2rad(40.0), 0]))
        T_wc[NUM_FRAMES // 2 : 2 * NUM_FRAMES // 3] = (
            T_wc[NUM_FRAMES // 2 : 2 * NUM_FRAMES // 3] @ turn
        )
    return T_wc


def exposure_of(case: Case, index: int) -> SensorOptions:
    noisy = NOISE.replace(read_noise=case.read_noise)
    if case.brightness == "drift":
        return noisy.replace(exposure=float(1.05 + 0.55 * np.sin(2 * np.pi * index / 40.0)))
    if case.brightness == "jumps":
        return noisy.replace(exposure=(1.0, 0.6, 1.5)[index // 7 % 3])
    return noisy


def render(case: Case, seed: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Image, depth as a Kinect reports it, true T_wc."""
    still = {"boxes": synthetic.boxes, "room": synthetic.room, "plane": synthetic.plane}[
        case.scene
    ](seed=seed)
    T_wc = trajectory_of(case, seed)
    T_cw = geometry.se3_inverse(T_wc)
    for i, pose in enumerate(T_cw):
        scene = still
        if case.moving_board:
            x = -1.2 + 2.4 * i / (NUM_FRAMES - 1)
            scene = still + synthetic.board(seed=seed, offset=(x, 0.0), size=(0.5, 0.8))
        after = T_cw[min(i + 1, NUM_FRAMES - 1)] @ T_wc[max(i - 1, 0)]
        frame = synthetic.render(
            scene, CAMERA, pose, width=WIDTH, height=HEIGHT, options=case.render,
            sensor=exposure_of(case, i), motion=0.5 * geometry.se3_log(after), seed=seed, index=i,
        )  # fmt: skip
        yield frame.image, synthetic.sense_depth(frame, CAMERA, seed=seed, index=i), T_wc[i]


def error_to_keyframe(result: OdometryResult, truth: list[np.ndarray]) -> tuple[float, float]:
    """(m, degrees) of the alignment that gave the frame its pose."""
    host = truth[result.keyframe]
    return frames.pose_error(result.alignment.T_th, np.linalg.inv(truth[result.frame]) @ host)


def run(case: Case, seed: int, depth_residual: bool) -> dict:
    options = OdometryOptions()
    depth_term = options.tracking.depth.replace(enabled=depth_residual)
    options = options.replace(tracking=options.tracking.replace(depth=depth_term))
    odometry = RgbdOdometry(CAMERA, options=options)
    truth: list[np.ndarray] = []
    errors, violations, lost = [], [], 0
    for i, (image, depth, T_wc) in enumerate(render(case, seed)):
        truth.append(T_wc)
        result = odometry.track(image, depth, timestamp=i / case.fps)
        if not has_pose(result):
            lost += 1
        elif i > 0:
            error = error_to_keyframe(result, truth)
            errors.append(error)
            if error[0] > BOUND_M or error[1] > BOUND_DEG:
                violations.append({"frame": i, "mm": 1e3 * error[0], "deg": error[1]})
    return {
        "seed": seed,
        "num_ok": len(errors),
        "num_lost": lost,
        "errors": errors,
        "violations": violations,
    }


def measure(repeats: int, only: list[str] | None = None) -> list[dict]:
    """`repeats` seeds of each case, photometric and with the depth residual."""
    rows = []
    for name, case in CASES.items():
        if only and not any(pattern in name for pattern in only):
            continue
        for depth_residual in (False, True):
            runs = [run(case, seed, depth_residual) for seed in range(repeats)]
            errors = np.array([e for r in runs for e in r["errors"]]).reshape(-1, 2)
            rows.append(
                {
                    "case": name,
                    "mode": "photometric + depth" if depth_residual else "photometric",
                    "seeds": repeats,
                    "num_frames": repeats * NUM_FRAMES,
                    "num_ok": sum(r["num_ok"] for r in runs),
                    "num_lost": sum(r["num_lost"] for r in runs),
                    "num_violations": sum(len(r["violations"]) for r in runs),
                    "median_mm": float(1e3 * np.median(errors[:, 0])) if len(errors) else None,
                    "max_mm": float(1e3 * errors[:, 0].max()) if len(errors) else None,
                    "max_deg": float(errors[:, 1].max()) if len(errors) else None,
                    "violations": [{"seed": r["seed"], **v} for r in runs for v in r["violations"]][
                        :10
                    ],
                }
            )
    return rows
