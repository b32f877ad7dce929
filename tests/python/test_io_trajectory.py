"""TUM and KITTI trajectory files and JSON lines: round trips and hostile input."""

import io
import math
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign.io import (
    JsonLinesWriter,
    read_json_lines,
    read_kitti_poses,
    read_tum_trajectory,
    write_kitti_poses,
    write_tum_trajectory,
)
from test_trajectory import wandering

POSE = "0 0 0 0 0 0 1"


def test_tum_round_trip(tmp_path: Path):
    path = wandering(50)
    write_tum_trajectory(path, tmp_path / "a.txt")
    again = read_tum_trajectory(tmp_path / "a.txt")
    np.testing.assert_array_equal(again.timestamps, path.timestamps)
    np.testing.assert_array_equal(again.positions, path.positions)
    np.testing.assert_allclose(again.T_wc, path.T_wc, atol=4e-16)
    stream = io.BytesIO()
    write_tum_trajectory(path, stream)
    assert stream.getvalue() == (tmp_path / "a.txt").read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_tum_columns_by_hand():
    """A quarter turn about z, xyzw, seen from (1, 2, 3)."""
    half = math.sqrt(0.5)
    text = f"\ufeff# comment\r\n\r\n7.5 1 2 3 0 0 {half} {half}\r\n"
    stamp, T_wc = read_tum_trajectory(io.BytesIO(text.encode()))[0]
    assert stamp == 7.5
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(T_wc, expected, atol=1e-15)


def test_kitti_round_trip_keeps_every_bit(tmp_path: Path):
    path = wandering(50)
    write_kitti_poses(path, tmp_path / "a.txt")
    again = read_kitti_poses(tmp_path / "a.txt", timestamps=path.timestamps)
    assert again == path
    np.testing.assert_allclose(read_kitti_poses(tmp_path / "a.txt").timestamps, np.arange(50) / 10)


def test_rounded_rotations_become_exact(tmp_path: Path):
    """KITTI's files have seven digits, TUM's four."""
    path = wandering(20)
    rows = path.T_wc[:, :3].reshape(-1, 12)
    text = "\n".join(" ".join(f"{x:.6e}" for x in row) for row in rows)
    again = read_kitti_poses(io.BytesIO(text.encode()), timestamps=path.timestamps)
    np.testing.assert_allclose(again.T_wc, path.T_wc, atol=2e-6)
    R = again.T_wc[:, :3, :3]
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.tile(np.eye(3), (20, 1, 1)), atol=1e-14)


@pytest.mark.parametrize(
    ("text", "line", "field", "reason"),
    [
        ("", 0, "", "holds no pose"),
        ("# only a comment\n", 0, "", "holds no pose"),
        (f"0 {POSE}\n1 0 0 0 0 0 1\n", 2, "", "expected 8 numbers"),
        (f"0 {POSE} 9\n", 1, "", "got 9"),
        ("0 0 0 nan 0 0 0 1\n", 1, "tz", "finite number, got 'nan'"),
        ("0 inf 0 0 0 0 0 1\n", 1, "tx", "finite"),
        ("0 0 0 0 0 0 0 one\n", 1, "qw", "'one'"),
        ("0 0 0 0 0 0 0 " + "9" * 500 + "\n", 1, "qw", "…"),
        ("0 0 0 0 0 0 0 0\n", 1, "qx qy qz qw", "norm is 0"),
        ("0 0 0 0 0 0 0 1.02\n", 1, "qx qy qz qw", "norm is 1.02"),
        (f"1 {POSE}\n0.5 {POSE}\n", 2, "timestamp", "later than the stamp before, 1.0, got 0.5"),
        (f"1 {POSE}\n1 {POSE}\n", 2, "timestamp", "later"),
        ("0,0,0,0,0,0,0,1\n", 1, "", "got 1"),
        (b"# \xff\n0 \x80", 1, "", "UTF-8"),
    ],
)
def test_bad_tum_files_are_refused(text, line: int, field: str, reason: str, tmp_path: Path):
    file = tmp_path / "bad.txt"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(raylign.FormatError) as caught:
        read_tum_trajectory(file)
    error = caught.value
    assert (error.file, error.line, error.field) == (str(file), line, field)
    assert reason in error.reason
    assert len(str(error)) < 300 + len(str(file))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "holds no pose"),
        ("1 0 0 0 0 1 0 0 0 0 1\n", "expected 12 numbers"),
        ("1 0 0 0 0 1 0 0 0 0 -1 0\n", "no rotation"),
        ("1 0 0 0 0 1 0 0 0 0 1.1 0\n", "no rotation"),
        ("1 0 0 0 0 1 0 nan 0 0 1 0\n", "finite"),
    ],
)
def test_bad_kitti_files_are_refused(text: str, reason: str):
    with pytest.raises(raylign.FormatError, match=reason):
        read_kitti_poses(io.BytesIO(text.encode()))


def test_kitti_stamps_must_fit():
    text = b"1 0 0 0 0 1 0 0 0 0 1 0\n" * 2
    with pytest.raises(raylign.ShapeError, match="holds 2 poses"):
        read_kitti_poses(io.BytesIO(text), timestamps=[0.0])
    with pytest.raises(raylign.OptionsError, match="increasing"):
        read_kitti_poses(io.BytesIO(text), timestamps=[1.0, 0.0])


def test_missing_files_and_folders(tmp_path: Path):
    for source in (tmp_path / "none.txt", tmp_path):
        with pytest.raises(raylign.FormatError, match="cannot be opened"):
            read_tum_trajectory(source)
    with pytest.raises(raylign.FormatError, match="cannot be written"):
        write_tum_trajectory(wandering(3), tmp_path / "no" / "a.txt")
    with pytest.raises(TypeError, match="path or a binary file"):
        read_kitti_poses(7)


def test_json_lines_round_trip(tmp_path: Path):
    rows = [
        {"frame": 0, "cost": 0.1 + 0.2, "pi": np.float64(math.pi), "T": np.eye(2)},
        {"frame": 1, "cost": math.inf, "reason": "lost\nhere \u2028 there"},
    ]
    with JsonLinesWriter(tmp_path / "log.jsonl") as log:
        log.write(rows[0])
        assert len(read_json_lines(tmp_path / "log.jsonl")) == 1  # on the disk at once
        log.write(rows[1])
        with pytest.raises(TypeError, match="no JSON form"):
            log.write({"x": object()})
    log.close()
    first, second = read_json_lines(tmp_path / "log.jsonl")
    assert first == {"frame": 0, "cost": 0.1 + 0.2, "pi": math.pi, "T": [[1.0, 0.0], [0.0, 1.0]]}
    assert second == {"frame": 1, "cost": "inf", "reason": "lost\nhere \u2028 there"}
    with pytest.raises(ValueError, match="closed"):
        log.write({})


@pytest.mark.parametrize("text", ['{"a": 1}\n{"a": ', "[1]\n", '{"a": 1} {"b": 2}', "[" * 100_000])
def test_bad_json_lines_are_refused(text: str, tmp_path: Path):
    (tmp_path / "log.jsonl").write_text(text)
    with pytest.raises(raylign.FormatError, match="JSON") as caught:
        read_json_lines(tmp_path / "log.jsonl")
    assert caught.value.line == text.count("\n", 0, len(text) - 1) + 1
    with pytest.raises(TypeError, match="path"):
        JsonLinesWriter(io.BytesIO())
    with pytest.raises(raylign.FormatError, match="cannot be written"):
        JsonLinesWriter(tmp_path)
