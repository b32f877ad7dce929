"""What all systems are given: grey images and depth of one pinhole camera, in memory."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

import raylign
from harness.problems import SHARED
from raylign.image import Interpolation, Undistorter, inscribed_camera

SEQUENCES = ("tum_fr1_xyz_37", "seven_scenes_250")


@dataclass(frozen=True)
class Frames:
    """A sequence, decoded: the same arrays go to every system.

    grey (N, H, W) uint8, depth (N, H, W) float32 m with NaN where there is none.
    """

    name: str
    camera: raylign.camera.PinholeCamera
    timestamps: np.ndarray
    grey: np.ndarray
    depth: np.ndarray
    truth: raylign.trajectory.Trajectory

    def __len__(self) -> int:
        return len(self.timestamps)

    @property
    def K(self) -> np.ndarray:
        return matrix(self.camera)


def matrix(camera: raylign.camera.PinholeCamera) -> np.ndarray:
    return np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1.0]])


def folder_of(name: str) -> Path:
    return SHARED / name


def load(name: str, length: int | None = None) -> Frames:
    """Pairs as `raylign.io.open_sequence` makes them, undistorted as `odometry.run` does."""
    sequence = raylign.io.open_sequence(folder_of(name))[:length]
    camera, undistort = sequence.pinhole, None
    grey, depth = [], []
    for frame in sequence:
        image = frame.image
        if image.ndim == 3:
            image = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        metres = frame.depth
        if isinstance(sequence.camera, raylign.camera.RadtanCamera):
            if undistort is None:
                height, width = image.shape
                camera = inscribed_camera(sequence.camera, width=width, height=height)
                undistort = Undistorter(
                    sequence.camera, width=width, height=height, new_camera=camera
                )
            image = undistort(image)
            metres = undistort(metres, interpolation=Interpolation.NEAREST)
        grey.append(np.ascontiguousarray(image))
        depth.append(np.ascontiguousarray(metres))
    return Frames(
        name, camera, sequence.timestamps, np.array(grey), np.array(depth), sequence.truth
    )


def chain(steps: list[np.ndarray]) -> np.ndarray:
    """T_wc of every frame from the motions T_next,before between them; the first is the world."""
    T_wc = [np.eye(4)]
    for step in steps:
        T_wc.append(T_wc[-1] @ np.linalg.inv(step))
    return np.array(T_wc)


def score(timestamps: np.ndarray, T_wc: np.ndarray, truth: raylign.trajectory.Trajectory) -> dict:
    """ATE after SE(3) alignment and RPE from frame to frame; mm and degrees."""
    found = np.isfinite(T_wc).all(axis=(1, 2))
    estimate = raylign.trajectory.Trajectory(timestamps[found], T_wc[found])
    result = raylign.trajectory.evaluate(estimate, truth, interpolate=True)
    return {
        "ate_mm": 1e3 * result.absolute.translation.rmse,
        "rpe_mm": 1e3 * result.per_frame.translation.rmse,
        "rpe_deg": float(np.degrees(result.per_frame.rotation.rmse)),
        "num_poses": int(found.sum()),
        "num_compared": result.num_matched,
    }


def pose_error(T: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """(m, degrees) of T truth⁻¹: how far apart, and turned, the camera positions are."""
    E = np.linalg.inv(T) @ truth
    cosine = np.clip((np.trace(E[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)
    sine = 0.5 * np.linalg.norm(
        [E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]
    )  # acos alone has an error of 1e-6 degrees near zero
    return float(np.linalg.norm(E[:3, 3])), float(np.degrees(np.arctan2(sine, cosine)))


def timing(seconds: np.ndarray) -> dict:
    milliseconds = 1e3 * np.asarray(seconds)
    return {
        "median_ms": float(np.median(milliseconds)),
        "p95_ms": float(np.percentile(milliseconds, 95)),
        "mean_ms": float(np.mean(milliseconds)),
    }
