"""7-Scenes sequences: `frame-000000.color.png`, `.depth.png`, `.pose.txt`."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from raylign._typing import F64, PathLike
from raylign.camera import PinholeCamera
from raylign.io._folders import check_positive, require_folder
from raylign.io._images import DepthCodec
from raylign.io._streams import format_error
from raylign.io._text import data_lines, numbers, read_text
from raylign.io.sequence import Calibration, Camera, RgbdFrame, RgbdSequence, SequenceReport
from raylign.io.trajectory import nearest_rotation
from raylign.trajectory import Trajectory

_COLOR = ".color"
_DEFAULT = PinholeCamera(585.0, 585.0, 320.0, 240.0)  # the data set's page: Kinect depth camera


def looks_like_seven_scenes(folder: Path) -> bool:
    """Whether the folder holds `frame-*.color.*` files."""
    return any(folder.glob("frame-*.color.*"))


def read_seven_scenes(
    folder: PathLike,
    *,
    camera: Camera | None = None,
    depth_scale: float = 1000.0,
    rate_hz: float = 30.0,
) -> RgbdSequence:
    """Open one `seq-XX` folder of 7-Scenes.

    Args:
        folder: holds the frames.
        camera: overrides `camera-intrinsics.txt` (3x3), or without that file the data set's
            (585, 585, 320, 240): the depth camera's, which its authors use for both.
        depth_scale: numbers of a depth file per m; 0 and 65535 are no measurement.
        rate_hz: frames per second; stamps are the number in the file name divided by it.

    Returns:
        RgbdSequence: truth from the `.pose.txt` files (T_wc); poses that are lost (not finite, no
        rotation) are left out and counted. Repeated colour frames: `duplicate_images()`.

    Raises:
        FormatError: there are no frames, or a pose or the intrinsics are malformed.
        OptionsError: a setting is out of range.
    """
    root = require_folder(folder)
    check_positive("depth_scale", depth_scale)
    check_positive("rate_hz", rate_hz)
    numbered = _numbered_images(root)
    report = SequenceReport(num_images=len(numbered))
    codec = DepthCodec(scale=depth_scale)
    frames: list[RgbdFrame] = []
    missing: list[str] = []
    for index, image in numbered:
        depth = image.with_name(image.name.split(_COLOR)[0] + ".depth.png")
        stamp = index / rate_hz
        if depth.is_file():
            frames.append(RgbdFrame(len(frames), stamp, image, depth, stamp, codec))
        else:
            missing.append(depth.name)
    if not frames:
        raise format_error(str(root), "", f"none of its {len(numbered)} images has a depth image")
    calibration = _calibration(root, camera)
    truth, num_invalid = _truth(frames)
    notices = () if camera is not None else (calibration.source,)
    return RgbdSequence(
        frames,
        format="seven_scenes",
        folder=root,
        calibration=calibration,
        truth=truth,
        report=replace(
            report,
            num_depths=len(frames),
            missing_files=tuple(missing),
            num_invalid_poses=num_invalid,
            notices=notices,
        ),
    )


def _numbered_images(root: Path) -> list[tuple[int, Path]]:
    found = []
    for path in root.glob(f"frame-*{_COLOR}.*"):
        digits = path.name.removeprefix("frame-").split(_COLOR)[0]
        if digits.isascii() and digits.isdigit():
            found.append((int(digits), path))
    found.sort()
    if not found:
        reason = "holds no frame-*.color.*"
        if any(child.is_dir() and looks_like_seven_scenes(child) for child in root.iterdir()):
            reason += "; its folders do: open one of them"
        raise format_error(str(root), "", reason)
    for (index, path), (following, _) in pairwise(found):
        if index == following:
            raise format_error(str(root), "", f"holds two images of frame {index}, {path.name} …")
    return found


def _calibration(root: Path, camera: Camera | None) -> Calibration:
    if camera is not None:
        return Calibration(camera, source="given by the caller")
    path = root / "camera-intrinsics.txt"
    if not path.is_file():
        source = "assumed the intrinsics of the data set's depth camera (585, 585, 320, 240)"
        return Calibration(_DEFAULT, source=source)
    K = _matrix(path, 3)
    if not (K[0, 0] > 0 and K[1, 1] > 0 and (K[[0, 1, 2, 2], [1, 0, 0, 1]] == 0).all()):
        raise format_error(str(path), "", "is no matrix [fx 0 cx; 0 fy cy; 0 0 1]")
    return Calibration(
        PinholeCamera(K[0, 0], K[1, 1], K[0, 2], K[1, 2]), source=f"intrinsics of {path.name}"
    )


def _truth(frames: list[RgbdFrame]) -> tuple[Trajectory | None, int]:
    """Poses of the frames that have one, and how many have none."""
    stamps, poses = [], []
    num_files = 0
    for frame in frames:
        path = frame.image_path.with_name(frame.image_path.name.split(_COLOR)[0] + ".pose.txt")
        if not path.is_file():
            continue
        num_files += 1
        T_wc = _matrix(path, 4, finite=False)
        R = nearest_rotation(T_wc[:3, :3])
        if R is None or not np.isfinite(T_wc).all() or list(T_wc[3]) != [0.0, 0.0, 0.0, 1.0]:
            continue
        T_wc[:3, :3] = R
        stamps.append(frame.timestamp)
        poses.append(T_wc)
    if num_files == 0:
        return None, 0
    return Trajectory(stamps, np.reshape(poses, (-1, 4, 4))), len(frames) - len(poses)


def _matrix(path: Path, size: int, *, finite: bool = True) -> F64:
    """A size x size matrix of whitespace-separated rows."""
    name, text = read_text(path)
    columns = tuple(f"column {i}" for i in range(size))
    rows = []
    for line, content in data_lines(text):
        if finite or "n" not in content.lower():  # nan, inf: a lost pose
            rows.append(numbers(content, columns, file=name, line=line))
        else:
            rows.append([float("nan")] * size)
    if len(rows) != size:
        raise format_error(name, "", f"expected {size} rows, got {len(rows)}")
    return np.array(rows)
