"""Calibration files: the kinds that are understood, and what is refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest

import raylign
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.io import read_calibration

PINHOLE = PinholeCamera(500.0, 510.0, 320.5, 240.25)
RADTAN = RadtanCamera(500.0, 510.0, 320.5, 240.25, 0.1, -0.2, 1e-3, -2e-3, 0.05)

OWN = """
camera:
  model: brown_conrady
  width: 640
  height: 480
  fx: 5e2
  fy: 510
  cx: 320.5
  cy: 240.25
  distortion: [0.1, -0.2, 1e-3, -2.0e-3, 0.05]
"""
ROS = """
image_width: 640
image_height: 480
camera_name: head
camera_matrix: {rows: 3, cols: 3, data: [500.0, 0, 320.5, 0, 510.0, 240.25, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0.001, -0.002, 0.05]}
"""
KALIBR = """
cam0:
  camera_model: pinhole
  intrinsics: [500.0, 510.0, 320.5, 240.25]
  distortion_model: radtan
  distortion_coeffs: [0.1, -0.2, 0.001, -0.002]
  resolution: [640, 480]
cam1: {}
"""
EUROC = """
sensor_type: camera
T_BS: {cols: 4, rows: 4, data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
resolution: [640, 480]
camera_model: pinhole
intrinsics: [500.0, 510.0, 320.5, 240.25]
distortion_model: radial-tangential
distortion_coefficients: [0, 0, 0, 0]
"""
ORB_SLAM = """%YAML:1.0
Camera.type: "PinHole"
Camera.fx: 500.0
Camera.fy: 510.0
Camera.cx: 320.5
Camera.cy: 240.25
Camera.k1: 0.1
Camera.k2: -0.2
Camera.p1: 0.001
Camera.p2: -0.002
Camera.k3: 0.05
Camera.width: 640
Camera.height: 480
"""


@pytest.mark.parametrize(
    ("text", "camera"),
    [
        (OWN, RADTAN),
        (ROS, RADTAN),
        (KALIBR, RadtanCamera(*RADTAN.params[:8], 0.0)),
        (EUROC, PINHOLE),
        (ORB_SLAM, RADTAN),
        (OWN.replace("[0.1, -0.2, 1e-3, -2.0e-3, 0.05]", "[]"), PINHOLE),
    ],
    ids=["own", "ros", "kalibr", "euroc", "orb_slam", "own_pinhole"],
)
def test_kinds_of_file(text: str, camera, tmp_path: Path):
    (tmp_path / "camera.yaml").write_text(text)
    calibration = read_calibration(tmp_path / "camera.yaml")
    assert calibration.camera == camera
    assert (calibration.width, calibration.height) == (640, 480)
    assert "camera.yaml" in calibration.source


@pytest.mark.parametrize("num_distortion", [0, 4, 5])
def test_what_opencv_writes(num_distortion: int, tmp_path: Path):
    path = tmp_path / "camera.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.asarray(PINHOLE.matrix()))
    if num_distortion:
        storage.write("distortion_coefficients", RADTAN.params[4 : 4 + num_distortion])
    storage.release()
    calibration = read_calibration(path)
    expected = {0: PINHOLE, 4: RadtanCamera(*RADTAN.params[:8], 0.0), 5: RADTAN}[num_distortion]
    assert calibration.camera == expected
    assert (calibration.width, calibration.height) == (640, 480)


@pytest.mark.parametrize(
    ("text", "field", "reason"),
    [
        ("", "", "no YAML mapping"),
        ("[1, 2]", "", "no YAML mapping"),
        ("a: [1", "", "is no YAML"),
        ("a: !!python/object/apply:os.system [ls]", "", "is no YAML"),
        ("[" * 2000, "", "is no YAML"),
        ("size: 3", "", "expected one of the keys"),
        ("camera: 7", "camera", "expected a mapping"),
        ("camera: {fx: 1, fy: 1, cx: 1}", "camera.cy", "is missing"),
        ("camera: {fx: .nan, fy: 1, cx: 1, cy: 1}", "camera.fx", "finite number, got 'nan'"),
        ("camera: {fx: true, fy: 1, cx: 1, cy: 1}", "camera.fx", "finite number"),
        ("camera: {fx: [1], fy: 1, cx: 1, cy: 1}", "camera.fx", "finite number"),
        ("camera: {fx: 0, fy: 1, cx: 1, cy: 1}", "camera.fx, fy", "must be > 0"),
        ("camera: {focal: 1}", "camera.focal", "is no field"),
        ("camera: {model: fisheye, fx: 1, fy: 1, cx: 1, cy: 1}", "camera.model", "'fisheye'"),
        ("camera: {width: 6.5, fx: 1, fy: 1, cx: 1, cy: 1}", "camera.width", "whole number"),
        ("camera: {baseline: -1, fx: 1, fy: 1, cx: 1, cy: 1}", "camera.baseline", ">= 0"),
        (OWN.replace("0.05]", "0.05, 0.3]"), "camera.distortion", "got 6 numbers"),
        (ROS.replace("plumb_bob", "equidistant"), "distortion", "'equidistant' is not known"),
        (ROS.replace(", 0, 0, 1]", "]"), "camera_matrix", "expected 9 numbers, got 6"),
        (ROS.replace("500.0, 0,", "500.0, 9,"), "camera_matrix", "is no matrix"),
        (KALIBR.replace("pinhole", "omni"), "cam0.camera_model", "'omni'"),
        (KALIBR.replace("500.0, ", ""), "cam0.intrinsics", "got 3 numbers"),
        (KALIBR.replace(", 0.001, -0.002]", "]"), "cam0.distortion", "got 2 numbers"),
        (KALIBR.replace("[640, 480]", "[640]"), "cam0.resolution", "width and height"),
        (ORB_SLAM.replace("PinHole", "KannalaBrandt8"), "Camera.type", "kannala"),
        (ORB_SLAM.replace("Camera.fy: 510.0", ""), "Camera.fy", "is missing"),
    ],
)
def test_bad_calibrations_are_refused(text: str, field: str, reason: str, tmp_path: Path):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(raylign.FormatError) as caught:
        read_calibration(path)
    assert caught.value.file == str(path)
    assert caught.value.field == field
    assert reason in caught.value.reason
    with pytest.raises(raylign.FormatError, match="cannot be opened"):
        read_calibration(tmp_path / "none.yaml")


def test_a_syntax_error_has_its_line(tmp_path: Path):
    (tmp_path / "camera.yaml").write_text("%YAML:1.0\n---\na: 1\nb: [1, 2\nc: 3\n")
    with pytest.raises(raylign.FormatError) as caught:
        read_calibration(tmp_path / "camera.yaml")
    assert caught.value.line == 5
