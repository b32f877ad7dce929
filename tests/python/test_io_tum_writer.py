"""`raylign.io.TumSequenceWriter`: what is written is read back."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from raylign.camera import PinholeCamera, RadtanCamera
from raylign.errors import FormatError, OptionsError
from raylign.geometry import se3_exp
from raylign.io import (
    RgbdSequence,
    TumSequenceWriter,
    open_sequence,
    read_image_folder,
    read_tum_rgbd,
)

CAMERA = RadtanCamera(51.0, 52.0, 7.5, 5.5, 0.1, -0.2, 0.003, 0.004, 0.5)
POSES = se3_exp([[0.0] * 6, [0.1, -0.2, 0.3, 0.2, 0.1, -0.3]])
IMAGES = np.arange(2 * 12 * 16, dtype=np.uint8).reshape(2, 12, 16)
DEPTHS = np.linspace(0.5, 4.0, 2 * 12 * 16).reshape(2, 12, 16).astype(np.float32)


def write(folder: Path, **changes: float) -> None:
    size = {"camera": CAMERA, "width": 16, "height": 12}
    with TumSequenceWriter(folder, **size, **changes) as writer:
        for i in range(2):
            writer.add(10.0 + i / 30.0, image=IMAGES[i], depth=DEPTHS[i], T_wc=POSES[i])


@pytest.mark.parametrize("read", [read_tum_rgbd, read_image_folder, open_sequence])
def test_round_trip(tmp_path: Path, read: Callable[[Path], RgbdSequence]):
    write(tmp_path / "a" / "b")
    sequence = read(tmp_path / "a" / "b")
    assert len(sequence) == 2
    assert sequence.calibration.camera == CAMERA
    assert (sequence.calibration.width, sequence.calibration.height) == (16, 12)
    assert sequence.truth is not None
    assert np.abs(sequence.truth.T_wc - POSES).max() < 1e-12
    for i, frame in enumerate(sequence):
        assert frame.timestamp == pytest.approx(10.0 + i / 30.0, abs=1e-6)
        assert np.array_equal(frame.image, IMAGES[i])
        assert np.abs(frame.depth - DEPTHS[i]).max() <= 0.5 / 5000.0 + 1e-6


def test_colour_and_sixteen_bits(tmp_path: Path):
    colour = np.zeros((12, 16, 3), np.uint8)
    colour[..., 0] = 200  # red
    deep = np.full((12, 16), 51234, np.uint16)
    with TumSequenceWriter(tmp_path, camera=CAMERA, width=16, height=12) as writer:
        writer.add(1.0, image=colour, depth=DEPTHS[0], T_wc=np.eye(4))
        writer.add(2.0, image=deep, depth=DEPTHS[0], T_wc=np.eye(4))
    assert np.array_equal(read_tum_rgbd(tmp_path)[0].image, colour)
    raw = cv2.imread(str(tmp_path / "rgb" / "2.000000.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(raw, deep)


def test_depth_that_the_format_cannot_hold_is_left_out(tmp_path: Path):
    depth = np.array([[np.nan, np.inf, -1.0, 0.0, 13.2, 13.1, 1e-5, 9e-5]])
    with TumSequenceWriter(tmp_path, camera=CAMERA, width=8, height=1) as writer:
        writer.add(1.0, image=np.zeros((1, 8), np.uint8), depth=depth, T_wc=np.eye(4))
    raw = cv2.imread(str(tmp_path / "depth" / "1.000000.png"), cv2.IMREAD_UNCHANGED)
    assert raw.dtype == np.uint16
    assert raw.tolist() == [[0, 0, 0, 0, 0, 65500, 0, 0]]


def test_calibration_is_what_opencv_reads(tmp_path: Path):
    write(tmp_path)
    storage = cv2.FileStorage(str(tmp_path / "calibration.yaml"), cv2.FILE_STORAGE_READ)
    K = storage.getNode("camera_matrix").mat()
    assert np.array_equal(K, [[51.0, 0.0, 7.5], [0.0, 52.0, 5.5], [0.0, 0.0, 1.0]])
    distortion = storage.getNode("distortion_coefficients").mat()
    assert distortion.tolist() == [[0.1, -0.2, 0.003, 0.004, 0.5]]
    assert storage.getNode("image_width").real() == 16


def test_interrupted_run_leaves_a_shorter_sequence(tmp_path: Path):
    def interrupted() -> None:
        with TumSequenceWriter(tmp_path, camera=CAMERA, width=16, height=12) as writer:
            writer.add(1.0, image=IMAGES[0], depth=DEPTHS[0], T_wc=np.eye(4))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert len(read_tum_rgbd(tmp_path)) == 1


def test_refusals(tmp_path: Path):
    size = {"camera": PinholeCamera(50.0, 50.0, 7.5, 5.5), "width": 16, "height": 12}
    with pytest.raises(OptionsError, match="depth_scale"):
        TumSequenceWriter(tmp_path / "a", **size, depth_scale=0.0)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep me")
    with pytest.raises(FormatError, match="not empty"):
        TumSequenceWriter(tmp_path / "full", **size)
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot be written"):
        TumSequenceWriter(tmp_path / "file", **size)
    writer = TumSequenceWriter(tmp_path / "b", **size)
    frame = {"image": IMAGES[0], "depth": DEPTHS[0], "T_wc": np.eye(4)}
    writer.add(2.0, **frame)
    with pytest.raises(OptionsError, match="timestamp"):
        writer.add(2.0, **frame)
    with pytest.raises(FormatError, match="cannot be"):
        writer.add(3.0, **frame | {"image": np.zeros((3, 4), np.complex128)})
