"""Damaged text of every reader of sequences and trajectories: a FormatError or a value, no more."""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign.io import (
    open_sequence,
    read_calibration,
    read_json_lines,
    read_kitti_poses,
    read_tum_trajectory,
    write_kitti_poses,
    write_tum_trajectory,
)
from test_io_calibration import EUROC, KALIBR, ORB_SLAM, OWN, ROS
from test_io_opening import make_euroc, make_folder, make_icl_nuim, make_seven_scenes, make_tum
from test_trajectory import wandering

TOKENS = [b"nan", b"-1", b"1e400", b"", b"\n", b" ", b"#", b"\0", b"\xff", b"9" * 30, b"[", b": "]


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """A piece cut out, or replaced by something else."""
    start = int(rng.integers(0, len(data)))
    stop = start + int(rng.integers(0, 12))
    return data[:start] + TOKENS[rng.integers(len(TOKENS))] + data[stop:]


def only_format_errors(read: Callable[[bytes], object], data: bytes, times: int, seed: int) -> int:
    """How many damaged inputs were refused."""
    rng = np.random.default_rng(seed)
    refused = 0
    read(data)
    for _ in range(times):
        try:
            read(damaged(data, rng))
        except raylign.FormatError as error:
            assert error.reason  # noqa: PT017  # most inputs are still good ones
            refused += 1
    return refused


def test_trajectories_and_logs():
    stream = io.BytesIO()
    write_tum_trajectory(wandering(4), stream)
    assert only_format_errors(
        lambda data: read_tum_trajectory(io.BytesIO(data)), stream.getvalue(), 400, 0
    )
    stream = io.BytesIO()
    write_kitti_poses(wandering(4), stream)
    assert only_format_errors(
        lambda data: read_kitti_poses(io.BytesIO(data)), stream.getvalue(), 400, 1
    )
    rows = b'{"a": 1.5, "b": [1, 2]}\n{"a": "x"}\n'
    assert only_format_errors(lambda data: read_json_lines(io.BytesIO(data)), rows, 400, 2)


@pytest.mark.parametrize("text", [OWN, ROS, KALIBR, EUROC, ORB_SLAM])
def test_calibrations(text: str, tmp_path: Path):
    def read(data: bytes) -> None:
        (tmp_path / "camera.yaml").write_bytes(data)
        read_calibration(tmp_path / "camera.yaml")

    assert only_format_errors(read, text.encode(), 100, 3)


@pytest.mark.parametrize(
    ("make", "file"),
    [
        (make_tum, "rgb.txt"),
        (make_tum, "depth.txt"),
        (make_icl_nuim, "associations.txt"),
        (make_seven_scenes, "frame-000001.pose.txt"),
        (make_seven_scenes, "camera-intrinsics.txt"),
        (make_euroc, "mav0/cam0/data.csv"),
        (make_euroc, "mav0/cam1/sensor.yaml"),
        (make_euroc, "mav0/state_groundtruth_estimate0/data.csv"),
        (make_folder, "calibration.yaml"),
    ],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_sequences(make: Callable[[Path], object], file: str, tmp_path: Path):
    make(tmp_path)

    def read(data: bytes) -> None:
        (tmp_path / file).write_bytes(data)
        open_sequence(tmp_path)

    assert only_format_errors(read, (tmp_path / file).read_bytes(), 60, 4)
