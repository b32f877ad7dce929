"""Tiny image sequences on the disk, in each format that raylign reads."""

from pathlib import Path

import cv2
import numpy as np

from raylign.io import write_tum_trajectory
from raylign.trajectory import Trajectory

WIDTH, HEIGHT = 8, 6


def image(index: int) -> np.ndarray:
    """(6, 8, 3) RGB: the index in red, columns in green, rows in blue."""
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    rgb[:, :, 0] = index
    rgb[:, :, 1] = np.arange(WIDTH)
    rgb[:, :, 2] = np.arange(HEIGHT)[:, None]
    return rgb


def depth(index: int) -> np.ndarray:
    """(6, 8) m, a quarter more per frame; two pixels were not measured."""
    metres = np.full((HEIGHT, WIDTH), 1.0 + 0.25 * index, np.float32)
    metres[0, 0] = metres[HEIGHT - 1, 2] = np.nan
    return metres


def save_image(path: Path, rgb: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), rgb[:, :, ::-1] if rgb.ndim == 3 else rgb)


def save_depth(path: Path, metres: np.ndarray, scale: float) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    raw = np.nan_to_num(np.rint(metres * scale), nan=0.0).astype(np.uint16)
    assert cv2.imwrite(str(path), raw)


def save_full_size(path: Path, value: int, dtype: type) -> None:
    """A plain image of 640x480, which TUM's known intrinsics are for."""
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), np.full((480, 640), value, dtype))


def path_of(stamps: np.ndarray) -> Trajectory:
    """A straight walk along x at 1 m/s from the first stamp."""
    t = np.zeros((len(stamps), 3))
    t[:, 0] = stamps - stamps[0]
    return Trajectory.from_quaternions(stamps, t, np.tile([0.0, 0.0, 0.0, 1.0], (len(stamps), 1)))


def make_tum(
    folder: Path,
    *,
    num_frames: int = 5,
    lag: float = 0.0,
    comment: str = "color images",
    rate: float = 30.0,
) -> np.ndarray:
    """A TUM tree; depth stamps are `lag` s later. Returns the stamps of the images."""
    stamps = np.round(1000.0 + np.arange(num_frames) / rate, 6)
    lists = {"rgb": [f"# {comment}"], "depth": ["# depth maps"]}
    for i, stamp in enumerate(stamps):
        save_full_size(folder / "rgb" / f"{stamp:.6f}.png", i, np.uint8)
        lists["rgb"].append(f"{stamp:.6f} rgb/{stamp:.6f}.png")
        later = stamp + lag
        save_full_size(folder / "depth" / f"{later:.6f}.png", 5000 + 1250 * i, np.uint16)
        lists["depth"].append(f"{later:.6f} depth/{later:.6f}.png")
    for kind, lines in lists.items():
        (folder / f"{kind}.txt").write_text("\n".join(lines) + "\n")
    write_tum_trajectory(path_of(stamps), folder / "groundtruth.txt")
    return stamps


def make_seven_scenes(folder: Path, *, num_frames: int = 5) -> None:
    """A 7-Scenes tree whose frame 3 repeats the image of frame 2."""
    for i in range(num_frames):
        stem = folder / f"frame-{i:06d}"
        save_image(stem.with_name(stem.name + ".color.png"), image(2 if i == 3 else i))
        save_depth(stem.with_name(stem.name + ".depth.png"), depth(i), 1000.0)
        T_wc = np.eye(4)
        T_wc[0, 3] = 0.1 * i
        np.savetxt(stem.with_name(stem.name + ".pose.txt"), T_wc, fmt="%.7e")
    K = [[585.0, 0.0, 4.0], [0.0, 586.0, 3.0], [0.0, 0.0, 1.0]]
    np.savetxt(folder / "camera-intrinsics.txt", K)
