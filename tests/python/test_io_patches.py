"""points.txt, poses.txt and lists of images: round trips, the original exercise's traps, damage."""

import io
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign import geometry
from raylign.io import (
    list_images,
    read_image,
    read_patch_points,
    read_poses,
    write_patch_points,
    write_poses,
)
from sequence_trees import save_image
from test_io_damage import only_format_errors

POSE = "0 0 0 0 0 0 1"
GREYS = " ".join("7" for _ in range(16))


def some_points(num_points: int = 30, num_values: int = 16):
    rng = np.random.default_rng(0)
    patches = rng.uniform(0, 400, (num_points, num_values)).astype(np.float32)
    return rng.normal(0, 3, (num_points, 3)), patches


@pytest.mark.parametrize("num_values", [0, 1, 16])
def test_points_round_trip_keeps_every_bit(num_values: int, tmp_path: Path):
    points, patches = some_points(num_values=num_values)
    write_patch_points(points, tmp_path / "points.txt", patches=patches)
    again = read_patch_points(tmp_path / "points.txt")
    np.testing.assert_array_equal(again.points, points)
    np.testing.assert_array_equal(again.patches, patches)
    assert again.points.dtype == np.float64
    assert again.patches.dtype == np.float32
    assert again.points.flags.c_contiguous


def test_points_like_the_loader_of_the_exercise_would_lose():
    """A point at x = 0 ends nothing, empty lines and comments are no points."""
    text = f"# x y z grey\n0 1 2 {GREYS}\r\n\n  1 0 0 {GREYS}  \n2 0 0 {GREYS}"
    points, patches = read_patch_points(io.BytesIO(text.encode()))
    assert points[:, 0].tolist() == [0.0, 1.0, 2.0]
    assert patches.shape == (3, 16)


@pytest.mark.parametrize(
    ("text", "num_values", "line", "field", "reason"),
    [
        ("", None, 0, "", "holds no point"),
        (f"1 2 3 {GREYS}\n1 2 3 {GREYS[2:]}\n1 2 3 {GREYS}", None, 2, "", "19 numbers expected"),
        (f"1 2 3 {GREYS[2:]}\n" + f"1 2 3 {GREYS}\n" * 2, None, 1, "", "but 18 found in line 1"),
        (f"1 2 3 {GREYS} 9\n", 16, 1, "", "19 numbers expected but 20 found in line 1"),
        ("1 2\n", None, 1, "", "3 numbers expected but 2 found in line 1"),
        (f"1 nan 3 {GREYS}\n", None, 1, "y", "finite number, got 'nan'"),
        (f"1 2 3 {GREYS}\n1 2 3 {GREYS[:-1]}x\n", None, 2, "g15", "'x'"),
        ("1 2 3 1e60\n", None, 1, "g0", "float32, got 1e+60"),
        (b"1 2 3 \xff", None, 1, "", "UTF-8"),
    ],
)
def test_bad_points_are_refused(text, num_values, line: int, field: str, reason: str, tmp_path):
    file = tmp_path / "points.txt"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(raylign.FormatError) as caught:
        read_patch_points(file, num_values=num_values)
    error = caught.value
    assert (error.file, error.line, error.field) == (str(file), line, field)
    assert reason in error.reason


def test_poses_round_trip(tmp_path: Path):
    T_cw = geometry.se3_exp(np.random.default_rng(1).normal(0, 1, (9, 6)))
    write_poses(T_cw, tmp_path / "poses.txt", timestamps=np.full(9, 1.46323e9))
    stamps, again = read_poses(tmp_path / "poses.txt")
    np.testing.assert_allclose(again, T_cw, atol=1e-15)
    np.testing.assert_array_equal(stamps, np.full(9, 1.46323e9))


def test_poses_map_the_world_to_the_camera_and_stamps_may_be_zero():
    half = np.sqrt(0.5)
    text = f"0 1 2 3 0 0 {half} {half}\n0 {POSE}\n"
    stamps, T_cw = read_poses(io.BytesIO(text.encode()))
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(T_cw[0], expected, atol=1e-15)
    assert stamps.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("text", "line", "field", "reason"),
    [
        ("# none\n", 0, "", "holds no pose"),
        (f"0 {POSE}\n0 {POSE} 1\n", 2, "", "expected 8 numbers"),
        (f"0 {POSE}\n0 0 0 0 0 0 0 0\n", 2, "qx qy qz qw", "norm is 0"),
        ("0 0 inf 0 0 0 0 1\n", 1, "ty", "finite number, got 'inf'"),
    ],
)
def test_bad_poses_are_refused(text: str, line: int, field: str, reason: str):
    with pytest.raises(raylign.FormatError, match="<stream>") as caught:
        read_poses(io.BytesIO(text.encode()))
    assert (caught.value.line, caught.value.field) == (line, field)
    assert reason in caught.value.reason


def test_damaged_points_and_poses():
    stream = io.BytesIO()
    write_patch_points(some_points(4)[0], stream, patches=some_points(4)[1])
    assert only_format_errors(
        lambda data: read_patch_points(io.BytesIO(data)), stream.getvalue(), 400, 0
    )
    stream = io.BytesIO()
    write_poses(geometry.se3_exp(np.zeros((3, 6))), stream)
    assert only_format_errors(lambda data: read_poses(io.BytesIO(data)), stream.getvalue(), 400, 1)


def test_writers_refuse_what_nobody_could_read(tmp_path: Path):
    points, patches = some_points(3)
    with pytest.raises(raylign.ShapeError, match=r"\(2, 16\)"):
        write_patch_points(points, tmp_path / "p.txt", patches=patches[:2])
    with pytest.raises(raylign.ShapeError, match="finite"):
        write_patch_points(points * np.nan, tmp_path / "p.txt")
    with pytest.raises(raylign.ShapeError, match=r"timestamps \(M,\)"):
        write_poses(np.eye(4), tmp_path / "p.txt")
    with pytest.raises(raylign.FormatError, match="cannot be written"):
        write_poses(np.eye(4)[None], tmp_path / "no" / "p.txt")
    assert list(tmp_path.iterdir()) == []


def test_images_in_order_and_what_is_missing(tmp_path: Path):
    names = [f"{i}.png" for i in (0, 1, 2, 4, 10)]
    for name in names:
        save_image(tmp_path / name, np.full((4, 5, 3), 9, np.uint8))
    (tmp_path / "poses.txt").touch()
    assert [path.name for path in list_images(tmp_path)] == names
    assert [path.name for path in list_images(tmp_path / "*.png", count=5)] == names
    assert list_images([tmp_path / "4.png", tmp_path / "1.png"])[0].name == "4.png"
    with pytest.raises(raylign.FormatError, match=r"6 images expected but 5 found, 3.png, .* more"):
        list_images(tmp_path, count=6)
    (tmp_path / "10.png").unlink()
    with pytest.raises(raylign.FormatError, match=r"5 images expected but 4 found, 3.png is miss"):
        list_images(tmp_path, count=5)
    for source in (tmp_path / "none", tmp_path / "x*.png", [tmp_path / "3.png"]):
        with pytest.raises(raylign.FormatError):
            list_images(source)


def test_images_keep_their_depth(tmp_path: Path):
    wide = np.array([[0, 65535], [257, 300]], np.uint16)
    save_image(tmp_path / "a.png", wide)
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), wide)
    color = np.zeros((2, 3, 3), np.uint8)
    color[..., 0] = 200
    save_image(tmp_path / "b.png", color)
    np.testing.assert_array_equal(read_image(tmp_path / "b.png"), color)
    np.save(tmp_path / "c.npy", np.float32([[1.5, 2.5]]))
    assert read_image(tmp_path / "c.npy").tolist() == [[1.5, 2.5]]
    np.save(tmp_path / "d.npy", np.float64([[1.5, 2.5]]))
    (tmp_path / "e.png").write_bytes(b"no image")
    for name in ("d.npy", "e.png", "f.png", "f.npy"):
        with pytest.raises(raylign.FormatError, match=name):
            read_image(tmp_path / name)


@pytest.mark.data
def test_the_exercise(shared_data: Path):
    folder = shared_data / "direct_ba"
    points, patches = read_patch_points(folder / "points.txt", num_values=16)
    stamps, T_cw = read_poses(folder / "poses.txt")
    assert points.shape == (4118, 3)
    assert patches.max() == pytest.approx(398.3, abs=0.05)
    assert np.mean((patches > 255).any(axis=1)) == pytest.approx(0.121, abs=5e-4)
    assert len(set(stamps)) == 1
    assert T_cw.shape == (7, 4, 4)
    paths = list_images(folder, count=7)
    assert read_image(paths[0]).shape[:2] == (480, 640)
