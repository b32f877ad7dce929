"""TUM, ICL-NUIM and 7-Scenes readers on generated trees, hostile ones, and real data."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.io import read_seven_scenes, read_tum_rgbd
from sequence_trees import (
    depth,
    image,
    make_seven_scenes,
    make_tum,
    save_full_size,
    save_image,
)

# --- what every sequence does --------------------------------------------------------------------


def test_a_sequence_is_indexed_sliced_and_iterated(tmp_path: Path):
    make_seven_scenes(tmp_path)
    sequence = read_seven_scenes(tmp_path)
    assert len(sequence) == 5
    assert [frame.index for frame in sequence] == [0, 1, 2, 3, 4]
    part = sequence[1:5:2]
    assert len(part) == 2
    assert [frame.index for frame in part] == [1, 3]
    assert part.camera == sequence.camera
    assert part.truth is sequence.truth
    assert part[-1].timestamp == sequence[3].timestamp
    np.testing.assert_array_equal(sequence.timestamps, np.arange(5) / 30.0)
    with pytest.raises(IndexError):
        sequence[5]
    with pytest.raises(raylign.OptionsError, match="forward"):
        sequence[::-1]
    assert repr(sequence).endswith("(seven_scenes), 5 frames, 5 true poses>")


def test_images_are_read_when_asked_for_and_kept_by_their_frame(tmp_path: Path):
    make_seven_scenes(tmp_path)
    sequence = read_seven_scenes(tmp_path)
    frame = sequence[1]
    np.testing.assert_array_equal(frame.image, image(1))
    assert frame.image is frame.image
    frame.image_path.unlink()
    assert frame.image is not None
    with pytest.raises(raylign.FormatError, match="cannot be opened"):
        _ = sequence[1].image


# --- TUM -----------------------------------------------------------------------------------------


def test_tum_tree(tmp_path: Path):
    stamps = make_tum(tmp_path / "rgbd_dataset_freiburg1_x", lag=0.002)
    sequence = read_tum_rgbd(tmp_path / "rgbd_dataset_freiburg1_x")
    np.testing.assert_array_equal(sequence.timestamps, stamps)
    assert sequence.format == "tum"
    assert sequence.has_depth
    assert sequence.truth is not None
    np.testing.assert_array_equal(sequence.truth.timestamps, stamps)
    assert sequence.report.time_offset_s == pytest.approx(0.002, abs=1e-6)
    frame = sequence[2]
    assert frame.depth_timestamp == pytest.approx(stamps[2] + 0.002)
    assert frame.image.shape == (480, 640)
    assert frame.depth is not None
    assert frame.depth.dtype == np.float32
    assert (frame.depth == 1.5).all()
    scaled = read_tum_rgbd(tmp_path / "rgbd_dataset_freiburg1_x", depth_scale=2500.0)
    assert (scaled[2].depth == 3.0).all()


@pytest.mark.parametrize(
    ("name", "fx", "kind"),
    [
        ("rgbd_dataset_freiburg1_desk", 517.3, RadtanCamera),
        ("tum_fr2_xyz", 520.9, RadtanCamera),
        ("FR3-office", 535.4, PinholeCamera),
        ("fr10", 525.0, PinholeCamera),
        ("desk", 525.0, PinholeCamera),
    ],
)
def test_tum_intrinsics_by_folder_name(name: str, fx: float, kind: type, tmp_path: Path):
    make_tum(tmp_path / name, num_frames=2)
    sequence = read_tum_rgbd(tmp_path / name)
    assert isinstance(sequence.camera, kind)
    assert sequence.camera.fx == fx
    assert sequence.pinhole == PinholeCamera(*sequence.camera.params[:4])
    (notice,) = sequence.report.notices
    assert ("assumed" in notice) == (fx == 525.0)
    own = PinholeCamera(500.0, 501.0, 3.0, 4.0)
    given = read_tum_rgbd(tmp_path / name, camera=own)
    assert given.camera == own
    assert given.report.notices == ()


def test_tum_intrinsics_by_comment(tmp_path: Path):
    make_tum(tmp_path / "strip", num_frames=2, comment="file: 'rgbd_dataset_freiburg2_desk.bag'")
    sequence = read_tum_rgbd(tmp_path / "strip")
    assert sequence.camera.fx == 520.9
    assert "comment" in sequence.report.notices[0]


@pytest.mark.parametrize("lag", [-0.0153, 0.0, 0.003, 0.0169])
def test_tum_pairs_are_consistent(lag: float, tmp_path: Path):
    """One lag for all; where −15 and +17 ms are both there, the later depth image."""
    make_tum(tmp_path, num_frames=8, lag=lag)
    sequence = read_tum_rgbd(tmp_path)
    lags = [frame.depth_timestamp - frame.timestamp for frame in sequence]
    expected = lag + 1.0 / 30.0 if lag < 0 else lag
    np.testing.assert_allclose(lags, expected, atol=2e-6)
    assert len(sequence) == (7 if lag < 0 else 8)
    assert len(sequence.report.unpaired_images) == len(sequence.report.unpaired_depths)
    given = read_tum_rgbd(tmp_path, time_offset_s=lag)
    assert len(given) == 8
    assert given.report.time_offset_s == lag


def test_tum_missing_files_and_doubles_are_counted(tmp_path: Path):
    stamps = make_tum(tmp_path, num_frames=6)
    (tmp_path / "rgb" / f"{stamps[1]:.6f}.png").unlink()
    (tmp_path / "depth" / f"{stamps[3]:.6f}.png").unlink()
    lines = (tmp_path / "rgb.txt").read_text().splitlines()
    (tmp_path / "rgb.txt").write_text("\n".join([*lines, lines[-1]]))
    sequence = read_tum_rgbd(tmp_path)
    report = sequence.report
    assert len(sequence) == 4
    assert report.missing_files == (f"rgb/{stamps[1]:.6f}.png", f"depth/{stamps[3]:.6f}.png")
    assert report.num_duplicate_stamps == 1
    assert report.num_images == report.num_depths == 6
    assert report.unpaired_images == (stamps[3],)
    assert report.unpaired_depths == (stamps[1],)


def test_tum_associations_in_either_order(tmp_path: Path):
    stamps = make_tum(tmp_path, num_frames=4, lag=0.01)
    color, deep = (
        [line.split() for line in (tmp_path / f"{kind}.txt").read_text().splitlines()[1:]]
        for kind in ("rgb", "depth")
    )
    for first, second in ((color, deep), (deep, color)):
        lines = [" ".join([*a, *b]) for a, b in zip(first, second, strict=True)]
        (tmp_path / "associations.txt").write_text("\n".join(lines))
        sequence = read_tum_rgbd(tmp_path)
        np.testing.assert_array_equal(sequence.timestamps, stamps)
        assert sequence[0].image_path.parent.name == "rgb"
        assert sequence.report.time_offset_s == pytest.approx(0.01, abs=1e-6)
    (tmp_path / "associations.txt").write_text("0 a.png 1\n")
    with pytest.raises(raylign.FormatError, match="got 3 words"):
        read_tum_rgbd(tmp_path)
    (tmp_path / "associations.txt").write_text("0 a.png 1 b.png\n")
    with pytest.raises(raylign.FormatError, match="none of its 1 pairs"):
        read_tum_rgbd(tmp_path)


def test_tum_without_lists_takes_stamps_from_the_names(tmp_path: Path):
    stamps = make_tum(tmp_path, num_frames=4)
    for kind in ("rgb", "depth"):
        (tmp_path / f"{kind}.txt").unlink()
    save_full_size(tmp_path / "rgb" / "1000.000000_broken.png", 0, np.uint8)
    np.testing.assert_array_equal(read_tum_rgbd(tmp_path).timestamps, stamps)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# nothing\n", "lists no file"),
        ("1.0\n", "rgb.txt:1: filename: is missing"),
        ("x rgb/a.png\n", "rgb.txt:1: timestamp: expected a finite number, got 'x'"),
        ("2 rgb/a.png\n1 rgb/b.png\n", "rgb.txt:2: timestamp: must not be earlier"),
        ("1 rgb/none.png\n2 ../gone/none.png\n", "none of its 2 files exists"),
        (b"\xff\xfe\x00", "no UTF-8"),
    ],
)
def test_bad_tum_lists_are_refused(text, message: str, tmp_path: Path):
    make_tum(tmp_path, num_frames=2)
    (tmp_path / "rgb.txt").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(raylign.FormatError, match=message):
        read_tum_rgbd(tmp_path)


def test_tum_without_anything_in_common_is_refused(tmp_path: Path):
    make_tum(tmp_path, num_frames=3, lag=10.0)
    with pytest.raises(raylign.FormatError, match=r"no depth image lies within 0\.02 s"):
        read_tum_rgbd(tmp_path)
    assert len(read_tum_rgbd(tmp_path, time_offset_s=10.0)) == 3
    with pytest.raises(raylign.OptionsError, match="max_difference_s"):
        read_tum_rgbd(tmp_path, max_difference_s=-1.0)
    with pytest.raises(raylign.OptionsError, match="depth_scale"):
        read_tum_rgbd(tmp_path, depth_scale=0.0)
    with pytest.raises(raylign.FormatError, match="is no folder"):
        read_tum_rgbd(tmp_path / "rgb.txt")


def test_damaged_images_are_typed_errors(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    stamps = make_tum(tmp_path, num_frames=4)
    names = [tmp_path / "rgb" / f"{stamp:.6f}.png" for stamp in stamps]
    names[0].write_bytes(b"")
    names[1].write_bytes(b"no image at all")
    save_image(names[2], image(0))
    deep = tmp_path / "depth" / f"{stamps[0]:.6f}.png"
    save_image(deep, image(0))
    sequence = read_tum_rgbd(tmp_path)
    for i, reason in ((0, "no readable image"), (1, "no readable image")):
        with pytest.raises(raylign.FormatError, match=reason):
            _ = sequence[i].image
    known = read_tum_rgbd(shutil.copytree(tmp_path, tmp_path / "fr1"))
    with pytest.raises(raylign.FormatError, match="is 8x6, the calibration is for 640x480"):
        _ = known[2].image
    with pytest.raises(raylign.FormatError, match="no depth image"):
        _ = sequence[0].depth
    assert capfd.readouterr().out == ""


# --- 7-Scenes ------------------------------------------------------------------------------------


def test_seven_scenes_tree(tmp_path: Path):
    make_seven_scenes(tmp_path)
    sequence = read_seven_scenes(tmp_path, rate_hz=10.0)
    assert sequence.camera == PinholeCamera(585.0, 586.0, 4.0, 3.0)
    assert sequence.duplicate_images() == [3]
    assert sequence.truth is not None
    np.testing.assert_allclose(sequence.truth.positions[:, 0], 0.1 * np.arange(5))
    np.testing.assert_array_equal(sequence.truth.timestamps, np.arange(5) / 10.0)
    np.testing.assert_array_equal(sequence[4].depth, depth(4))
    own = PinholeCamera(1.0, 2.0, 3.0, 4.0)
    assert read_seven_scenes(tmp_path, camera=own).camera == own
    (tmp_path / "camera-intrinsics.txt").unlink()
    default = read_seven_scenes(tmp_path)
    assert default.camera.fx == 585.0
    assert "assumed" in default.report.notices[0]


def test_seven_scenes_saturated_depth_is_no_depth(tmp_path: Path):
    make_seven_scenes(tmp_path, num_frames=2)
    far = depth(0)
    far[2, 2] = 65.535
    import cv2

    raw = np.nan_to_num(np.rint(far * 1000.0)).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "frame-000000.depth.png"), raw)
    read = read_seven_scenes(tmp_path)[0].depth
    assert read is not None
    assert np.isnan(read[2, 2])
    assert np.isnan(read).sum() == 3


def test_seven_scenes_gaps_are_counted(tmp_path: Path):
    make_seven_scenes(tmp_path)
    (tmp_path / "frame-000001.depth.png").unlink()
    (tmp_path / "frame-000002.pose.txt").write_text("nan nan nan nan\n" * 4)
    (tmp_path / "frame-000003.pose.txt").write_text("2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n")
    (tmp_path / "frame-000004.pose.txt").unlink()
    sequence = read_seven_scenes(tmp_path)
    assert sequence.report.missing_files == ("frame-000001.depth.png",)
    assert sequence.report.num_invalid_poses == 3
    assert sequence.truth is not None
    assert sequence.truth.timestamps.tolist() == [0.0]
    assert sequence.timestamps.tolist() == [0.0, 2 / 30, 3 / 30, 4 / 30]


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("frame-000001.pose.txt", "1 0 0 0\n", "expected 4 rows, got 1"),
        ("frame-000001.pose.txt", "1 0 0\n", r"pose.txt:1: expected 4 numbers"),
        ("frame-000001.pose.txt", "1 0 0 x\n", r"pose.txt:1: column 3: .*'x'"),
        ("camera-intrinsics.txt", "1 0 0\n0 1 0\n0 0 1\n1 1 1\n", "expected 3 rows"),
        ("camera-intrinsics.txt", "1 9 0\n0 1 0\n0 0 1\n", "no matrix"),
    ],
)
def test_bad_seven_scenes_are_refused(file: str, text: str, message: str, tmp_path: Path):
    make_seven_scenes(tmp_path, num_frames=2)
    (tmp_path / file).write_text(text)
    with pytest.raises(raylign.FormatError, match=message):
        read_seven_scenes(tmp_path)


def test_seven_scenes_without_frames_is_refused(tmp_path: Path):
    make_seven_scenes(tmp_path / "seq-01", num_frames=2)
    with pytest.raises(raylign.FormatError, match="open one of them"):
        read_seven_scenes(tmp_path)
    for path in (tmp_path / "seq-01").glob("*.depth.png"):
        path.unlink()
    with pytest.raises(raylign.FormatError, match="none of its 2 images"):
        read_seven_scenes(tmp_path / "seq-01")
    with pytest.raises(raylign.OptionsError, match="rate_hz"):
        read_seven_scenes(tmp_path / "seq-01", rate_hz=0.0)


# --- real data -----------------------------------------------------------------------------------


@pytest.mark.data
def test_tum_strip(shared_data: Path):
    sequence = read_tum_rgbd(shared_data / "tum_fr1_xyz_37")
    assert len(sequence) == 36
    assert sequence.report.time_offset_s == pytest.approx(0.018, abs=2e-3)
    assert sequence.report.max_difference_s < 0.005
    assert sequence.camera.fx == 517.3
    assert sequence.truth is not None
    assert len(sequence.truth) == 400
    frame = sequence[0]
    assert frame.image.shape == (480, 640, 3)
    assert frame.depth is not None
    assert 0.3 < np.nanmedian(frame.depth) < 3.0
    assert 0.5 < np.isfinite(frame.depth).mean() < 1.0


@pytest.mark.data
def test_seven_scenes_strip(shared_data: Path):
    sequence = read_seven_scenes(shared_data / "seven_scenes_250")
    assert len(sequence) == 250
    assert sequence.duplicate_images() == [228, 234, 240, 245]
    assert sequence.truth is not None
    assert len(sequence.truth) == 250
    frame = sequence[100]
    assert frame.depth is not None
    assert np.nanmax(frame.depth) < 65.0
    assert frame.image.shape == (480, 640, 3)
