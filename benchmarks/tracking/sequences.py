"""Real sequences: ATE, RPE and time of every system on the same frames."""

import json
import subprocess
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from raylign.odometry import OdometryOptions, RgbdOdometry, has_pose
from tracking import cv_odometry, frames

WORKER = Path(__file__).resolve().parents[1] / "workers" / "open3d_worker.py"
OPEN3D_TERMS = ("color", "hybrid")
REFERENCE = "cv2.Odometry RGB"
# the systems whose ms can be measured again and again; Open3D takes minutes and runs once
RAYLIGN = ("raylign, photometric", "raylign, photometric + depth")
FRAME_TO_FRAME = "raylign, photometric + depth, frame to frame"


def raylign_options(system: str) -> OdometryOptions:
    """The defaults; without the depth residual, or with a keyframe on every frame, by name."""
    options = OdometryOptions()
    if system == RAYLIGN[0]:
        without_depth = options.tracking.depth.replace(enabled=False)
        return options.replace(tracking=options.tracking.replace(depth=without_depth))
    if system == FRAME_TO_FRAME:
        return options.replace(keyframe_rule=options.keyframe_rule.replace(distance_weight=1e6))
    return options


def run_raylign(data: frames.Frames, options: OdometryOptions) -> dict:
    odometry = RgbdOdometry(data.camera, options=options)
    results, seconds = [], []
    for i in range(len(data)):
        start = time.perf_counter()
        result = odometry.track(data.grey[i], data.depth[i], timestamp=float(data.timestamps[i]))
        seconds.append(time.perf_counter() - start)
        results.append(result)
    T_wc = np.array([r.T_wc if has_pose(r) else np.full((4, 4), np.nan) for r in results])
    return {
        **frames.score(data.timestamps, T_wc, data.truth),
        "num_failed": sum(not has_pose(r) for r in results),
        "num_keyframes": sum(r.is_keyframe for r in results),
        "seconds": seconds[1:],  # the first frame is only a keyframe
        "is_keyframe": [bool(r.is_keyframe) for r in results[1:]],
        "point_evaluations": [_point_evaluations(r) for r in results[1:]],
    }


def _point_evaluations(result: object) -> int:
    return sum(level.num_points * level.num_evaluations for level in result.alignment.levels)


def from_steps(data: frames.Frames, steps: list, seconds: np.ndarray) -> dict:
    """A failed step is taken as no motion, as its caller would have to."""
    T_wc = frames.chain([np.asarray(T) if ok else np.eye(4) for ok, T in steps])
    return {
        **frames.score(data.timestamps, T_wc, data.truth),
        "num_failed": sum(not ok for ok, _ in steps),
        "seconds": list(map(float, seconds)),
    }


def run_open3d(data: frames.Frames, python: Path, term: str) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frames.npz"
        np.savez(path, K=data.K, grey=data.grey, depth=data.depth)
        output = subprocess.run(
            [python, WORKER, path, term], check=True, capture_output=True, text=True
        )
    answer = json.loads(output.stdout.splitlines()[-1])
    return from_steps(data, answer["steps"], answer["seconds"]) | {"version": answer["version"]}


def measure_once(data: frames.Frames) -> dict[str, dict]:
    """One round: raylign and cv2 in turns."""
    round_ = {}
    for system in (*RAYLIGN, FRAME_TO_FRAME):
        round_[system] = run_raylign(data, raylign_options(system))
    for kind in cv_odometry.TYPES:
        steps, seconds = cv_odometry.follow(kind, data.K, data.grey, data.depth)
        round_[f"cv2.Odometry {kind}"] = from_steps(data, steps, seconds)
    return round_


def summarise(rounds: list[dict[str, dict]]) -> list[dict]:
    """Errors of the first round (they do not change), medians over the rounds of the times."""
    rows = []
    for system, first in rounds[0].items():
        times = [frames.timing(r[system]["seconds"]) for r in rounds if system in r]
        row = {k: v for k, v in first.items() if k not in _SERIES}
        row["system"] = system
        for key in times[0]:
            row[key] = float(np.median([t[key] for t in times]))
        row["cv2_rgb_ratio"] = float(
            np.median(
                [
                    np.median(r[REFERENCE]["seconds"]) / np.median(r[system]["seconds"])
                    for r in rounds
                    if system in r
                ]
            )
        )
        rows.append(row)
    return rows


_SERIES = ("seconds", "is_keyframe", "point_evaluations")


def measure(names: list[str], repeats: int, peers: Path | None) -> list[dict]:
    results = []
    for name in names:
        if not frames.folder_of(name).is_dir():
            results.append({"sequence": name, "error": "not at hand: set RAYLIGN_DATA"})
            continue
        data = frames.load(name)
        rounds = [measure_once(data) for _ in range(repeats)]
        if peers is not None:
            for term in OPEN3D_TERMS:
                rounds[0][f"Open3D {term}"] = run_open3d(data, peers, term)
        results.append(
            {
                "sequence": name,
                "num_frames": len(data),
                "size": list(data.grey.shape[:0:-1]),
                "cv2": cv2.__version__,
                "rows": summarise(rounds),
            }
        )
    return results
