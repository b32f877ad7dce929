"""Where the milliseconds of a tracked frame go, one thread, seven_scenes_250."""

import time

import numpy as np

from raylign import depth
from raylign.odometry import OdometryOptions
from raylign.tracking import Frame, Keyframe, KeyframeOptions, Tracker, TrackingOptions
from tracking import cv_odometry, frames, sequences

SEQUENCE = "seven_scenes_250"
BUDGET = 4000
# Streamed per point of a pass: ray, D, V, I, gradient (7 floats), σ² read and written (2); the
# target's cell of intensity and gradient (4 floats) counted once, because neighbours share cells.
PHOTOMETRIC_BYTES = 4 * (7 + 2 + 4)
# ... and D, its gradient and variance of the target (4), σ² read and written (2).
DEPTH_BYTES = 4 * (4 + 2)


def options_of(depth_residual: bool, max_points: int | None) -> OdometryOptions:
    """The defaults, with or without the depth residual; another budget of points, or theirs."""
    options = OdometryOptions()
    term = options.tracking.depth.replace(enabled=depth_residual)
    options = options.replace(tracking=options.tracking.replace(depth=term))
    if max_points is None:
        return options
    return options.replace(keyframe=options.keyframe.replace(max_points=max_points))


def measure_odometry(data: frames.Frames, repeats: int) -> list[dict]:
    """Whole frames: pyramids, depth conversion, alignment, keyframes; images are in memory. In each
    round cv2.Odometry RGB follows the same frames."""
    configurations = {
        "photometric": options_of(False, None),
        "photometric + depth": options_of(True, None),
        f"photometric, {BUDGET} points": options_of(False, BUDGET),
        f"photometric + depth, {BUDGET} points": options_of(True, BUDGET),
        "photometric, all points": options_of(False, 0),
        "photometric + depth, all points": options_of(True, 0),
    }
    rounds, cv2_ms = [], []
    for _ in range(repeats):
        rounds.append(
            {name: sequences.run_raylign(data, options) for name, options in configurations.items()}
        )
        _, seconds = cv_odometry.follow("RGB", data.K, data.grey, data.depth)
        cv2_ms.append(1e3 * float(np.median(seconds)))
    rows = []
    for name in configurations:
        times = [frames.timing(r[name]["seconds"]) for r in rounds]
        first = rounds[0][name]
        keyframe_ms = [
            1e3 * s
            for r in rounds
            for s, is_keyframe in zip(r[name]["seconds"], r[name]["is_keyframe"], strict=True)
            if is_keyframe
        ]
        ratios = [ms / t["median_ms"] for ms, t in zip(cv2_ms, times, strict=True)]
        rows.append(
            {
                "system": name,
                **{k: float(np.median([t[k] for t in times])) for k in times[0]},
                "cv2_rgb_ms": float(np.median(cv2_ms)),
                "cv2_rgb_ratio": float(np.median(ratios)),
                "num_keyframes": first["num_keyframes"],
                "keyframe_median_ms": float(np.median(keyframe_ms)) if keyframe_ms else None,
                "point_evaluations": float(np.median(first["point_evaluations"])),
                "ate_mm": first["ate_mm"],
                "rpe_mm": first["rpe_mm"],
            }
        )
    return rows


def measure_stages(data: frames.Frames, repeats: int) -> dict:
    """Steps of a frame by themselves, median ms, over frames spread through the sequence."""
    chosen = range(0, len(data) - 1, max(1, len(data) // 40))
    model = OdometryOptions().depth_model
    keyframe_options = OdometryOptions().keyframe
    tracking = OdometryOptions().tracking
    levels = range(tracking.finest_level, tracking.coarsest_level + 1)
    times: dict[str, list[float]] = {
        name: [] for name in ("inverse_depth", "frame", "frame_with_depth", "keyframe_points")
    }
    for _ in range(repeats):
        for i in chosen:
            marks = [time.perf_counter()]
            D, V = depth.inverse_depth(data.depth[i], model=model)
            marks.append(time.perf_counter())
            Frame(data.grey[i], data.camera)
            marks.append(time.perf_counter())
            frame = Frame(data.grey[i], data.camera, inverse_depth=D, variance=V)
            marks.append(time.perf_counter())
            keyframe = Keyframe.from_frame(frame, options=keyframe_options)
            for level in levels:
                keyframe.points(level=level)
            marks.append(time.perf_counter())
            for name, seconds in zip(times, np.diff(marks), strict=True):
                times[name].append(seconds)
    stages = {name: float(1e3 * np.median(values)) for name, values in times.items()}
    stages["keyframe_setup"] = float(
        1e3
        * np.median(
            np.array(times["inverse_depth"])
            + np.array(times["frame_with_depth"])
            + np.array(times["keyframe_points"])
        )
    )
    return stages


def measure_passes(data: frames.Frames, repeats: int) -> list[dict]:
    """`Tracker.track` of prepared frames: ns per evaluation of a point, evaluations per level."""
    model = OdometryOptions().depth_model
    base = OdometryOptions().tracking
    rows = []
    for depth_residual in (False, True):
        for max_points in (OdometryOptions().keyframe.max_points, BUDGET, 0):
            options = base.replace(depth=base.depth.replace(enabled=depth_residual))
            chosen = OdometryOptions().keyframe.replace(max_points=max_points)
            rows.append(
                {
                    "system": "photometric + depth" if depth_residual else "photometric",
                    "max_points": max_points,
                    **_passes(data, options, chosen, model, repeats),
                    "bytes_per_point": PHOTOMETRIC_BYTES + depth_residual * DEPTH_BYTES,
                }
            )
    return rows


def _passes(
    data: frames.Frames,
    options: TrackingOptions,
    keyframe_options: KeyframeOptions,
    model: depth.DepthModel,
    repeats: int,
) -> dict:
    tracker = Tracker(options=options)
    seconds, evaluations = [], []
    per_level: dict[int, list[tuple[int, int]]] = {}
    chosen = range(0, len(data) - 3, max(1, len(data) // 40))
    for i in chosen:
        made = []
        for k in (i, i + 3):
            D, V = depth.inverse_depth(data.depth[k], model=model)
            made.append(Frame(data.grey[k], data.camera, inverse_depth=D, variance=V))
        keyframe = Keyframe.from_frame(made[0], options=keyframe_options)
        tracker.set_keyframe(keyframe)
        tracker.track(made[1], T_init=np.eye(4))  # builds the point lists
        for _ in range(repeats):
            start = time.perf_counter()
            result = tracker.track(made[1], T_init=np.eye(4))
            seconds.append(time.perf_counter() - start)
            evaluations.append(sum(x.num_points * x.num_evaluations for x in result.levels))
        for x in result.levels:
            per_level.setdefault(x.level, []).append((x.num_points, x.num_evaluations))
    ns = 1e9 * np.array(seconds) / np.maximum(evaluations, 1)
    return {
        "align_median_ms": float(1e3 * np.median(seconds)),
        "ns_per_point_evaluation": float(np.median(ns)),
        "levels": [
            {
                "level": level,
                "points": float(np.median([p for p, _ in values])),
                "evaluations": float(np.mean([e for _, e in values])),
            }
            for level, values in sorted(per_level.items(), reverse=True)
        ],
    }


def triad_gb_per_s() -> float:
    """a = b + s c over 48 MB, one thread, the best of 7 by NumPy in blocks that stay in L1: what
    the memory gives."""
    n = 2_000_000
    a, b, c = (np.ones(n) for _ in range(3))
    best = np.inf
    for _ in range(7):
        start = time.perf_counter()
        for block in range(0, n, 2000):
            part = slice(block, block + 2000)
            np.multiply(c[part], 3.0, out=a[part])
            np.add(a[part], b[part], out=a[part])
        best = min(best, time.perf_counter() - start)
    return 3 * 8 * n / best / 1e9


def measure(repeats: int) -> dict:
    if not frames.folder_of(SEQUENCE).is_dir():
        return {"error": "not at hand: set RAYLIGN_DATA"}
    data = frames.load(SEQUENCE)
    return {
        "odometry": measure_odometry(data, repeats),
        "stages": measure_stages(data, repeats),
        "passes": measure_passes(data, repeats),
        "triad_gb_per_s": triad_gb_per_s(),
    }
