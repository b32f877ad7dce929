"""A BAL problem as a folder in COLMAP's binary format (cameras, images, points3D), by NumPy alone.

Format: colmap.github.io/format.html. COLMAP looks along +z with v down: both axes flip, and the
distortion is unchanged. Identifiers start at 1. The principal point is 0: pixels stay BAL's.
"""

from pathlib import Path

import numpy as np

from harness.judge import Problem

RADIAL = 3  # COLMAP's camera model f, cx, cy, k1, k2
POINT_HEADER = np.dtype(
    [("id", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3), ("error", "<f8"), ("length", "<u8")]
)
CAMERA = np.dtype([("id", "<u4"), ("model", "<i4"), ("size", "<u8", 2), ("parameters", "<f8", 5)])
IMAGE = np.dtype([("id", "<u4"), ("q", "<f8", 4), ("t", "<f8", 3), ("camera", "<u4")])
PIXEL = np.dtype([("uv", "<f8", 2), ("point", "<u8")])


def write_model(problem: Problem, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    order = np.argsort(problem.camera_index, kind="stable")
    starts = np.searchsorted(problem.camera_index[order], np.arange(len(problem.cameras) + 1))
    write_cameras(problem.cameras, folder / "cameras.bin")
    write_images(problem, order, starts, folder / "images.bin")
    slot = np.empty(len(order), dtype=np.int64)  # an observation's place in its image
    slot[order] = np.arange(len(order)) - np.repeat(starts[:-1], np.diff(starts))
    write_points(problem, slot, folder / "points3D.bin")


def count(number: int) -> bytes:
    return np.uint64(number).tobytes()


def write_cameras(cameras: np.ndarray, path: Path) -> None:
    rows = np.zeros(len(cameras), dtype=CAMERA)
    rows["id"] = np.arange(1, len(cameras) + 1)
    rows["model"] = RADIAL
    rows["size"] = 1  # not used without a principal point
    rows["parameters"][:, 0] = cameras[:, 6]
    rows["parameters"][:, 3:] = cameras[:, 7:]
    path.write_bytes(count(len(rows)) + rows.tobytes())


def quaternions(w: np.ndarray) -> np.ndarray:
    """Angle-axis of BAL's R_cw to wxyz of COLMAP's: a half turn about x from the left."""
    theta = np.linalg.norm(w, axis=1)
    real = np.cos(theta / 2.0)
    imaginary = w * (0.5 * np.sinc(theta / (2.0 * np.pi)))[:, None]
    x, y, z = imaginary.T
    return np.stack([-x, real, -z, y], axis=1)  # (0, 1, 0, 0) · (real, x, y, z)


def write_images(problem: Problem, order: np.ndarray, starts: np.ndarray, path: Path) -> None:
    q = quaternions(problem.cameras[:, :3])
    t = problem.cameras[:, 3:6] * [1.0, -1.0, -1.0]
    with path.open("wb") as file:
        file.write(count(len(q)))
        for i in range(len(q)):
            rows = order[starts[i] : starts[i + 1]]
            file.write(np.array((i + 1, q[i], t[i], i + 1), dtype=IMAGE).tobytes())
            file.write(f"{i:06d}".encode() + b"\0" + count(len(rows)))
            pixels = np.empty(len(rows), dtype=PIXEL)
            pixels["uv"] = problem.pixels[rows] * [1.0, -1.0]
            pixels["point"] = problem.point_index[rows] + 1
            file.write(pixels.tobytes())


def write_points(problem: Problem, slot: np.ndarray, path: Path) -> None:
    """Headers and tracks have different lengths: placed byte by byte, without a Python loop."""
    num_points = len(problem.points)
    order = np.argsort(problem.point_index, kind="stable")
    lengths = np.bincount(problem.point_index, minlength=num_points)
    headers = np.zeros(num_points, dtype=POINT_HEADER)
    headers["id"] = np.arange(1, num_points + 1)
    headers["xyz"] = problem.points
    headers["length"] = lengths
    track = np.empty((len(order), 2), dtype="<u4")
    track[:, 0] = problem.camera_index[order] + 1
    track[:, 1] = slot[order]
    first = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    header_at = POINT_HEADER.itemsize * np.arange(num_points) + 8 * first
    is_header = np.zeros(POINT_HEADER.itemsize * num_points + 8 * len(order), dtype=bool)
    for byte in range(POINT_HEADER.itemsize):
        is_header[header_at + byte] = True
    data = np.empty(len(is_header), dtype=np.uint8)
    data[is_header] = headers.view(np.uint8)
    data[~is_header] = track.reshape(-1).view(np.uint8)
    path.write_bytes(count(num_points) + data.tobytes())
