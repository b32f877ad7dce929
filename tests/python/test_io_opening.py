"""ICL-NUIM, stereo and plain folders on generated trees, and finding out the format."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign.camera import PinholeCamera
from raylign.io import (
    SEQUENCE_FORMATS,
    open_sequence,
    read_euroc,
    read_icl_nuim,
    read_image_folder,
    read_stereo_pair,
    write_tum_trajectory,
)
from sequence_trees import (
    HEIGHT,
    WIDTH,
    depth,
    image,
    make_seven_scenes,
    make_tum,
    path_of,
    save_depth,
    save_full_size,
    save_image,
)

CAMERA = "camera: {fx: 4, fy: 5, cx: 3.5, cy: 2.5, width: 8, height: 6, baseline: 0.5}\n"
SENSOR = """
T_BS: {{cols: 4, rows: 4, data: [0, -1, 0, 0, 1, 0, 0, {y}, 0, 0, 1, 0.25, 0, 0, 0, 1]}}
resolution: [8, 6]
camera_model: pinhole
intrinsics: [4, 5, 3.5, 2.5]
distortion_model: radial-tangential
distortion_coefficients: [{k1}, 0, 0, 0]
"""


def make_icl_nuim(folder: Path) -> None:
    lines = []
    for i in range(3):
        color = np.zeros((480, 640, 3), np.uint8)
        color[0] = 200
        save_image(folder / "rgb" / f"{i}.png", color)
        metres = np.ones((480, 640), np.float32)
        metres[0] = 2.0
        save_depth(folder / "depth" / f"{i}.png", metres, 5000.0)
        lines.append(f"{i} depth/{i}.png {i} rgb/{i}.png")
    (folder / "associations.txt").write_text("\n".join(lines))
    write_tum_trajectory(path_of(np.arange(3.0)), folder / "livingRoom0.gt.freiburg")


def make_euroc(folder: Path, *, num_frames: int = 4, y: float = 0.5, k1: float = 0.0) -> None:
    """A rig turned by 90° about its z axis: the body's y is along the cameras' x."""
    base = folder / "mav0"
    rows = ["#timestamp [ns],filename"]
    for i in range(num_frames):
        stamp = 1403636579763555584 + 50_000_000 * i
        save_image(base / "cam0" / "data" / f"{stamp}.png", image(i)[:, :, 1])
        save_depth(base / "disparity" / f"{stamp}.png", np.full((HEIGHT, WIDTH), 2.0 + i), 256.0)
        rows.append(f"{stamp},{stamp}.png\r")
    (base / "cam0" / "data.csv").write_text("\n".join(rows) + "\n")
    (base / "cam0" / "sensor.yaml").write_text(SENSOR.format(y=0.0, k1=k1))
    (base / "cam1").mkdir()
    (base / "cam1" / "sensor.yaml").write_text(SENSOR.format(y=y, k1=k1))
    truth = base / "state_groundtruth_estimate0"
    truth.mkdir()
    line = "1403636579763555584,1,2,3,1,0,0,0,0.1,0.1,0.1,0,0,0,0,0,0\n"
    (truth / "data.csv").write_text("#timestamp, p, q wxyz, v, b\n" + line)


def make_stereo(folder: Path) -> None:
    save_image(folder / "left.png", image(0)[:, :, 1])
    save_image(folder / "disparity.png", np.full((HEIGHT, WIDTH), 4, np.uint8))
    for i in (1, 2, 10):
        save_image(folder / f"{i:06d}.png", image(i)[:, :, 1])


def make_folder(folder: Path, text: str = CAMERA, *, names: str = "{:d}") -> None:
    for i in range(3):
        save_image(folder / "rgb" / f"{names.format(8 + i)}.png", image(i))
        save_depth(folder / "depth" / f"{names.format(8 + i)}.png", depth(i), 1000.0)
    (folder / "calibration.yaml").write_text(text)


MAKERS = {
    "icl_nuim": make_icl_nuim,
    "stereo": make_stereo,
    "folder": make_folder,
    "tum": make_tum,
    "seven_scenes": make_seven_scenes,
    "euroc": make_euroc,
}
OPTIONS = {"stereo": {"camera": PinholeCamera(4.0, 5.0, 3.5, 2.5), "baseline": 0.5}}


@pytest.mark.parametrize("format", SEQUENCE_FORMATS)
def test_every_format_is_found_out(format: str, tmp_path: Path):
    MAKERS[format](tmp_path)
    options = OPTIONS.get(format, {})
    for asked in ("auto", format):
        sequence = open_sequence(tmp_path, format=asked, **options)
        assert sequence.format == format
        assert len(sequence) >= 3
        assert (np.diff(sequence.timestamps) > 0).all()
        frame = sequence[0]
        assert frame.image.dtype == np.uint8
        assert frame.depth is not None
        assert frame.depth.shape == frame.image.shape[:2]
        assert frame.depth.dtype == np.float32
        assert frame.depth.flags.c_contiguous
        assert frame.image.flags.c_contiguous


def test_unknown_folders_are_a_clear_error(tmp_path: Path):
    with pytest.raises(raylign.FormatError) as caught:
        open_sequence(tmp_path)
    for sign in ("rgb.txt", "frame-*.color.*", "cam0/data.csv", "calibration.yaml", "left.png"):
        assert sign in caught.value.reason
    with pytest.raises(raylign.FormatError, match="is no folder"):
        open_sequence(tmp_path / "none")
    with pytest.raises(raylign.OptionsError, match=r"format must be auto, .*'bag'"):
        open_sequence(tmp_path, format="bag")
    make_seven_scenes(tmp_path)
    with pytest.raises(TypeError, match="time_offset_s"):
        open_sequence(tmp_path, time_offset_s=0.1)


# --- ICL-NUIM ------------------------------------------------------------------------------------


def test_icl_nuim_is_turned_upside_down_so_that_its_poses_hold(tmp_path: Path):
    """A point p_w is seen at the same pixel of the file with K of the page (fy < 0), and ours."""
    make_icl_nuim(tmp_path)
    sequence = read_icl_nuim(tmp_path)
    frame = sequence[0]
    assert frame.depth is not None
    assert (frame.image[-1] == 200).all()
    assert (frame.depth[-1] == 2.0).all()
    assert sequence.truth is not None
    np.testing.assert_array_equal(sequence.truth.positions[:, 0], [0.0, 1.0, 2.0])
    p_c = np.array([0.3, 0.4, 2.0])
    u, v = 481.2 * 0.15 + 319.5, -480.0 * 0.2 + 239.5
    (ours_u, ours_v), _ = sequence.camera.project(p_c)
    assert ours_u == pytest.approx(u)
    assert ours_v == pytest.approx(479 - v)
    assert "upside down" in sequence.report.notices[0]


def test_bad_icl_nuim_is_refused(tmp_path: Path):
    make_icl_nuim(tmp_path)
    shutil.copy(tmp_path / "livingRoom0.gt.freiburg", tmp_path / "other.gt.freiburg")
    with pytest.raises(raylign.FormatError, match="several trajectories"):
        open_sequence(tmp_path)
    (tmp_path / "associations.txt").unlink()
    with pytest.raises(raylign.FormatError, match="holds none of associations"):
        open_sequence(tmp_path)


# --- stereo --------------------------------------------------------------------------------------


def test_euroc_depth_and_truth(tmp_path: Path):
    make_euroc(tmp_path)
    sequence = read_euroc(tmp_path / "mav0")
    assert sequence.calibration.baseline == pytest.approx(0.5)
    assert sequence.timestamps[0] == pytest.approx(1403636579.763555584, abs=1e-6)
    np.testing.assert_allclose(np.diff(sequence.timestamps), 0.05, atol=1e-6)
    for i, frame in enumerate(sequence):
        np.testing.assert_allclose(frame.depth, 4.0 * 0.5 / (2.0 + i))
    assert sequence.truth is not None
    T_wc = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3.25], [0, 0, 0, 1]]
    np.testing.assert_allclose(sequence.truth.T_wc[0], T_wc)
    halved = read_euroc(tmp_path, baseline=0.25, disparity_scale=128.0)
    np.testing.assert_allclose(halved[0].depth, 4.0 * 0.25 / 4.0)


def test_euroc_gaps(tmp_path: Path):
    make_euroc(tmp_path)
    base = tmp_path / "mav0"
    next((base / "cam0" / "data").glob("*.png")).unlink()
    sorted((base / "disparity").glob("*.png"))[-1].unlink()
    sequence = read_euroc(tmp_path)
    assert len(sequence) == 3
    assert len(sequence.report.missing_files) == 1
    shutil.rmtree(base / "disparity")
    (base / "cam1" / "sensor.yaml").unlink()
    bare = read_euroc(tmp_path)
    assert not bare.has_depth
    assert bare[0].depth is None
    assert "no depth" in bare.report.notices[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": -0.5}, "not rectified"),
        ({"y": 0.0}, "not rectified"),
        ({"k1": 0.1}, "needs rectified images"),
    ],
)
def test_euroc_that_is_not_rectified_is_refused(change, message: str, tmp_path: Path):
    make_euroc(tmp_path, **change)
    with pytest.raises(raylign.FormatError, match=message):
        read_euroc(tmp_path)


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("cam0/data.csv", "#\n", "lists no image"),
        ("cam0/data.csv", "1\n", "data.csv:1: filename"),
        ("cam0/data.csv", "x,a.png\n", "finite number, got 'x'"),
        ("cam0/data.csv", "1.5,a.png\n", "whole nanoseconds"),
        ("cam0/data.csv", "2,a.png\n1,b.png\n", "data.csv:2: timestamp"),
        ("cam0/data.csv", "2,a.png\n", "none of its 1 images"),
        ("cam1/sensor.yaml", "T_BS: [1, 2]\n", "T_BS: expected a rigid 4x4"),
        ("cam1/sensor.yaml", "T_BS: {data: [[2]]}\n", "T_BS: expected a rigid 4x4"),
        ("state_groundtruth_estimate0/data.csv", "1,2,3\n", "got 3"),
        ("state_groundtruth_estimate0/data.csv", "1,0,0,0,2,0,0,0\n", "unit quaternion"),
        ("state_groundtruth_estimate0/data.csv", "1,0,0,nan,1,0,0,0\n", "z: .*finite"),
        ("state_groundtruth_estimate0/data.csv", "#\n", "holds no pose"),
    ],
)
def test_bad_euroc_files_are_refused(file: str, text: str, message: str, tmp_path: Path):
    make_euroc(tmp_path)
    (tmp_path / "mav0" / file).write_text(text)
    with pytest.raises(raylign.FormatError, match=message):
        read_euroc(tmp_path)


def test_stereo_pair(tmp_path: Path):
    make_stereo(tmp_path)
    sequence = read_stereo_pair(tmp_path, **OPTIONS["stereo"])
    assert [f.image_path.stem for f in sequence] == ["left", "000001", "000002", "000010"]
    np.testing.assert_allclose(sequence[0].depth, 0.5)
    assert sequence[1].depth is None
    with pytest.raises(raylign.FormatError, match=r"no calibration\.yaml"):
        open_sequence(tmp_path)
    (tmp_path / "calibration.yaml").write_text(CAMERA)
    np.testing.assert_allclose(open_sequence(tmp_path)[0].depth, 0.5)
    (tmp_path / "calibration.yaml").write_text(CAMERA.replace(", baseline: 0.5", ""))
    with pytest.raises(raylign.FormatError, match="baseline: is not known"):
        open_sequence(tmp_path)


# --- plain folders -------------------------------------------------------------------------------


def test_plain_folder(tmp_path: Path):
    """Numbers sort as numbers: 8, 9, 10."""
    make_folder(tmp_path)
    sequence = read_image_folder(tmp_path)
    assert [frame.image_path.stem for frame in sequence] == ["8", "9", "10"]
    np.testing.assert_allclose(sequence.timestamps, np.arange(3) / 30.0)
    for i, frame in enumerate(sequence):
        np.testing.assert_array_equal(frame.image, image(i))
        np.testing.assert_array_equal(frame.depth, depth(i))
    assert sequence.calibration.width == WIDTH
    faster = read_image_folder(tmp_path, rate_hz=10.0, depth_scale=500.0)
    np.testing.assert_allclose(faster.timestamps, np.arange(3) / 10.0)
    assert faster[0].depth is not None
    assert np.nanmax(faster[0].depth) == 2.0
    own = PinholeCamera(1.0, 2.0, 3.0, 4.0)
    assert read_image_folder(tmp_path, camera=own).camera == own


def test_plain_folder_with_every_field(tmp_path: Path):
    make_folder(tmp_path / "a")
    (tmp_path / "a" / "rgb").rename(tmp_path / "a" / "left")
    (tmp_path / "a" / "depth").rename(tmp_path / "a" / "deep")
    (tmp_path / "a" / "times.txt").write_text("1.5\n2.5\n4.5\n")
    write_tum_trajectory(path_of(np.arange(3.0)), tmp_path / "a" / "gt.txt")
    text = "sequence: {images: left, depth: deep, depth_scale: 500, max_depth: 2.75,\n"
    text += "  timestamps: times.txt, truth: gt.txt}\n"
    (tmp_path / "elsewhere.yaml").write_text(CAMERA + text)
    sequence = read_image_folder(tmp_path / "a", calibration=tmp_path / "elsewhere.yaml")
    np.testing.assert_array_equal(sequence.timestamps, [1.5, 2.5, 4.5])
    assert sequence.truth is not None
    assert np.isnan(sequence[2].depth).all()
    assert np.nanmax(sequence[1].depth) == 2.5


def test_plain_folder_with_stamps_in_the_names(tmp_path: Path):
    make_folder(tmp_path)
    shutil.rmtree(tmp_path / "rgb")
    shutil.rmtree(tmp_path / "depth")
    for i in range(6):
        save_image(tmp_path / "rgb" / f"{10 + i / 30:.4f}.png", image(i))
        save_depth(tmp_path / "depth" / f"{10.011 + i / 30:.4f}.png", depth(i), 1000.0)
    sequence = read_image_folder(tmp_path)
    assert len(sequence) == 6
    assert sequence.report.time_offset_s == pytest.approx(0.011, abs=2e-4)
    np.testing.assert_array_equal(sequence[3].depth, depth(3))


def test_float_depth_and_disparity_files(tmp_path: Path):
    make_folder(tmp_path, CAMERA + "sequence: {disparity: disparity}\n")
    shutil.rmtree(tmp_path / "depth")
    (tmp_path / "disparity").mkdir()
    for i in range(3):
        values = np.full((HEIGHT, WIDTH), 2.0, np.float32)
        values[0, 0], values[0, 1], values[0, 2] = -1.0, np.inf, 0.0
        np.save(tmp_path / "disparity" / f"{8 + i}.npy", values)
    read = read_image_folder(tmp_path)[0].depth
    assert read is not None
    assert np.isnan(read[0, :3]).all()
    assert np.isnan(read).sum() == 3
    assert np.nanmax(read) == 1.0
    (tmp_path / "disparity" / "8.npy").write_bytes(b"\x93NUMPY")
    with pytest.raises(raylign.FormatError, match=r"no readable \.npy"):
        _ = read_image_folder(tmp_path)[0].depth


def test_images_without_depth(tmp_path: Path):
    make_folder(tmp_path)
    shutil.rmtree(tmp_path / "depth")
    sequence = read_image_folder(tmp_path)
    assert len(sequence) == 3
    assert not sequence.has_depth
    assert sequence[0].depth is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sequence: 3", "sequence: expected a mapping"),
        ("sequence: {scale: 3}", r"sequence\.scale: is no field"),
        ("sequence: {depth_scale: many}", r"sequence\.depth_scale: expected a number"),
        ("sequence: {rate_hz: 0}", r"sequence\.rate_hz: must be > 0"),
        ("sequence: {rate_hz: .nan}", r"sequence\.rate_hz: must be > 0"),
        ("sequence: {images: none}", "holds no folder none"),
        ("sequence: {depth: none}", "none: is no folder"),
        ("sequence: {depth: depth, disparity: depth}", "not both"),
        ("sequence: {timestamps: none.txt}", "cannot be opened"),
        ("sequence: {timestamps: calibration.yaml}", "expected a finite number"),
        ("sequence: {truth: none.txt}", "cannot be opened"),
    ],
)
def test_bad_layouts_are_refused(text: str, message: str, tmp_path: Path):
    make_folder(tmp_path, CAMERA + text + "\n")
    with pytest.raises(raylign.FormatError, match=message):
        read_image_folder(tmp_path)


def test_folders_that_cannot_be_paired_are_refused(tmp_path: Path):
    make_folder(tmp_path)
    for path in list((tmp_path / "depth").iterdir()):
        path.rename(path.with_name("d" + path.name))
    by_order = read_image_folder(tmp_path)
    np.testing.assert_array_equal(by_order[2].depth, depth(2))
    next((tmp_path / "depth").iterdir()).unlink()
    with pytest.raises(raylign.FormatError, match="3 images and 2 depth images share neither"):
        read_image_folder(tmp_path)
    shutil.rmtree(tmp_path / "depth")
    (tmp_path / "depth").mkdir()
    with pytest.raises(raylign.FormatError, match="holds no image"):
        read_image_folder(tmp_path)
    (tmp_path / "calibration.yaml").unlink()
    with pytest.raises(raylign.FormatError, match=r"holds none of calibration\.yaml"):
        read_image_folder(tmp_path)


def test_a_wrong_size_is_refused(tmp_path: Path):
    make_folder(tmp_path, CAMERA)
    save_full_size(tmp_path / "rgb" / "8.png", 1, np.uint8)
    with pytest.raises(raylign.FormatError, match="is 640x480, the calibration is for 8x6"):
        _ = read_image_folder(tmp_path)[0].image


@pytest.mark.data
def test_real_folders_are_found_out(shared_data: Path):
    camera = PinholeCamera(718.856, 718.856, 607.1928, 185.2157)
    stereo = open_sequence(shared_data / "kitti_stereo", camera=camera, baseline=0.573)
    assert (stereo.format, len(stereo)) == ("stereo", 6)
    read = stereo[0].depth
    assert read is not None
    assert 5.0 < np.nanmedian(read) < 50.0
    assert open_sequence(shared_data / "tum_fr1_xyz_37").format == "tum"
    assert open_sequence(shared_data / "seven_scenes_250").format == "seven_scenes"
    fr1 = open_sequence(shared_data / "tum_pairs")
    assert len(fr1) == 4
    assert "assumed" in fr1.report.notices[0]
