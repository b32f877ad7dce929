"""Rectified stereo: EuRoC's folders with disparity, and KITTI's left image with its disparity."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from raylign import geometry
from raylign._typing import F64, PathLike
from raylign.camera import PinholeCamera
from raylign.io._folders import (
    DEPTH_SUFFIXES,
    check_positive,
    image_files,
    require_folder,
)
from raylign.io._images import DepthCodec
from raylign.io._streams import format_error
from raylign.io._text import data_lines, number, read_text
from raylign.io.calibration import load_yaml, read_calibration
from raylign.io.sequence import Calibration, Camera, RgbdFrame, RgbdSequence, SequenceReport
from raylign.trajectory import Trajectory

_TRUTH = "state_groundtruth_estimate0/data.csv"
_RECTIFIED = 1e-3  # rad, and of the baseline: how far apart two rectified cameras' axes may be
_CSV_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def looks_like_euroc(folder: Path) -> bool:
    """Whether there is `cam0/data.csv`, here or in `mav0/`."""
    return any((base / "cam0" / "data.csv").is_file() for base in (folder, folder / "mav0"))


def looks_like_stereo(folder: Path) -> bool:
    """Whether there are `left.png` and `disparity.png`."""
    return all(any(folder.glob(f"{name}.*")) for name in ("left", "disparity"))


def read_euroc(
    folder: PathLike,
    *,
    camera: Camera | None = None,
    baseline: float | None = None,
    disparity_scale: float = 0.0,
) -> RgbdSequence:
    """Open rectified stereo in EuRoC's (ASL) layout, depth from disparity images.

    `cam0/data.csv` (stamp in ns, file) lists the left images in `cam0/data`; `disparity/` beside
    `cam0` holds one image of the same stem for each, in px: 16-bit files are 256 times that (as in
    KITTI), float files (`.npy`, `.tiff`, `.pfm`) as they are. Without that folder frames have no
    depth. Truth is `state_groundtruth_estimate0`, moved from the body to the left camera.

    Args:
        folder: the sequence, or its `mav0`.
        camera: overrides `cam0/sensor.yaml`; must be the rectified one for depth.
        baseline: m; overrides what the `T_BS` of the two `sensor.yaml` say.
        disparity_scale: numbers of an integer disparity file per px; 0: 256 for 16 bits, else 1.

    Returns:
        RgbdSequence: frames whose disparity file is missing have no depth.

    Raises:
        FormatError: a file is missing or malformed; or there is disparity and the cameras are not
            rectified (distortion, rotation or an offset across the baseline between them).
        OptionsError: a setting is out of range.
    """
    root = require_folder(folder)
    base = root if (root / "cam0").is_dir() else root / "mav0"
    rows = _csv_rows(base / "cam0" / "data.csv")
    disparity = base / "disparity"
    calibration = _euroc_calibration(base, camera, baseline, disparity.is_dir())
    files = _by_stem(disparity) if disparity.is_dir() else {}
    codec = _disparity_codec(calibration, disparity_scale)
    size = (calibration.width, calibration.height)
    frames: list[RgbdFrame] = []
    missing: list[str] = []
    for stamp, name in rows:
        image = base / "cam0" / "data" / name
        if not image.is_file():
            missing.append(name)
            continue
        depth = files.get(image.stem)
        depth_stamp = None if depth is None else stamp
        frames.append(RgbdFrame(len(frames), stamp, image, depth, depth_stamp, codec, size))
    if not frames:
        reason = f"none of its {len(rows)} images exists"
        raise format_error(str(base / "cam0" / "data.csv"), "", reason)
    report = SequenceReport(
        num_images=len(rows),
        num_depths=len(files),
        unpaired_images=tuple(f.timestamp for f in frames if files and f.depth_path is None),
        missing_files=tuple(missing),
        notices=() if files else ("there is no folder disparity/: frames have no depth",),
    )
    return RgbdSequence(
        frames,
        format="euroc",
        folder=root,
        calibration=calibration,
        truth=_euroc_truth(base),
        report=report,
    )


def read_stereo_pair(
    folder: PathLike,
    *,
    camera: Camera | None = None,
    baseline: float | None = None,
    disparity_scale: float = 0.0,
    rate_hz: float = 10.0,
) -> RgbdSequence:
    """Open a left image with its disparity and the images that follow, which have no depth.

    `left.png`, `disparity.png` (px, or 256 px in 16 bits) and numbered images `000001.png` and so
    on in one folder, the layout of small direct-alignment examples on KITTI.

    Args:
        folder: holds the images.
        camera: overrides `calibration.yaml` in the folder; one of the two must be there.
        baseline: m; overrides the file's.
        disparity_scale: numbers of an integer disparity file per px; 0: 256 for 16 bits, else 1.
        rate_hz: frames per second; stamps are positions divided by it.

    Raises:
        FormatError: a file is missing or malformed, or camera or baseline are not known.
        OptionsError: a setting is out of range.
    """
    root = require_folder(folder)
    check_positive("rate_hz", rate_hz)
    images = image_files(root)
    named = {path.stem: path for path in images}
    for name in ("left", "disparity"):
        if name not in named:
            raise format_error(str(root), "", f"holds no {name}.png")
    calibration = _given_or_file(root, camera, baseline)
    codec = _disparity_codec(calibration, disparity_scale)
    size = (calibration.width, calibration.height)
    following = [path for path in images if path.stem.isdecimal()]
    frames = [RgbdFrame(0, 0.0, named["left"], named["disparity"], 0.0, codec, size)]
    for i, path in enumerate(following, start=1):
        frames.append(RgbdFrame(i, i / rate_hz, path, None, None, codec, size))
    return RgbdSequence(
        frames,
        format="stereo",
        folder=root,
        calibration=calibration,
        report=SequenceReport(num_images=len(frames), num_depths=1, notices=(calibration.source,)),
    )


def _given_or_file(root: Path, camera: Camera | None, baseline: float | None) -> Calibration:
    file = root / "calibration.yaml"
    if camera is not None:
        calibration = Calibration(camera, source="given by the caller")
    elif file.is_file():
        calibration = read_calibration(file)
    else:
        reason = "there is no calibration.yaml: write one, or pass camera= and baseline="
        raise format_error(str(root), "", reason)
    if baseline is not None:
        check_positive("baseline", baseline)
        calibration = replace(calibration, baseline=baseline)
    if calibration.baseline == 0.0:
        raise format_error(str(root), "baseline", "is not known: disparity gives no depth")
    if not isinstance(calibration.camera, PinholeCamera):
        raise format_error(str(file), "distortion", "disparity needs rectified images")
    return calibration


def _disparity_codec(calibration: Calibration, disparity_scale: float) -> DepthCodec:
    if disparity_scale != 0.0:
        check_positive("disparity_scale", disparity_scale)
    return DepthCodec(
        scale=disparity_scale, disparity_fb=calibration.camera.fx * calibration.baseline
    )


def _by_stem(folder: Path) -> dict[str, Path]:
    return {path.stem: path for path in image_files(folder, DEPTH_SUFFIXES)}


def _csv_rows(path: Path) -> list[tuple[float, str]]:
    """Stamps (ns in the file) in s and file names."""
    name, text = read_text(path)
    rows: list[tuple[float, str]] = []
    for line, content in data_lines(text):
        words = [word.strip() for word in content.split(",")]
        if len(words) < 2 or not words[1]:
            raise format_error(name, "filename", "is missing", line=line)
        stamp = _nanoseconds(words[0], name, line)
        if rows and stamp <= rows[-1][0]:
            raise format_error(name, "timestamp", "must be later than the one before", line=line)
        rows.append((stamp, words[1]))
    if not rows:
        raise format_error(name, "", "lists no image")
    return rows


def _nanoseconds(token: str, file: str, line: int) -> float:
    if not (token.isascii() and token.isdecimal()) or len(token) > 20:
        number(token, file=file, line=line, field="timestamp")
        raise format_error(file, "timestamp", "expected whole nanoseconds", line=line)
    return int(token) / 1e9


def _euroc_calibration(
    base: Path, camera: Camera | None, baseline: float | None, has_disparity: bool
) -> Calibration:
    left = base / "cam0" / "sensor.yaml"
    if camera is not None:
        calibration = Calibration(camera, source="given by the caller")
    else:
        calibration = read_calibration(left)
    if baseline is not None:
        check_positive("baseline", baseline)
    elif has_disparity:
        baseline = _rectified_baseline(left, base / "cam1" / "sensor.yaml")
    if has_disparity and not isinstance(calibration.camera, PinholeCamera):
        reason = "disparity needs rectified images, whose camera has no distortion"
        raise format_error(str(left), "distortion_coefficients", reason)
    return replace(calibration, baseline=baseline or 0.0)


def _rectified_baseline(left: Path, right: Path) -> float:
    """Distance of the right camera along the left one's x axis, m."""
    T_lr = geometry.se3_inverse(_body_to_sensor(left)) @ _body_to_sensor(right)
    t = T_lr[:3, 3]
    turn = float(np.linalg.norm(geometry.so3_log(np.ascontiguousarray(T_lr[:3, :3]))))
    if turn > _RECTIFIED or t[0] <= 0.0 or np.abs(t[1:]).max() > _RECTIFIED * t[0]:
        reason = (
            f"the cameras are not rectified: turned by {turn:.2g} rad, offset {t.round(6).tolist()}"
            " m; rectify the images and write the rectified cameras' T_BS"
        )
        raise format_error(str(right), "T_BS", reason)
    return float(t[0])


def _body_to_sensor(path: Path) -> F64:
    """T_BS of a sensor.yaml: maps sensor points to the body; identity where there is none."""
    name, root = load_yaml(path)
    node = root.get("T_BS")
    if node is None:
        return np.eye(4)
    data = node.get("data") if isinstance(node, dict) else node
    try:
        T = np.array(data, dtype=np.float64).reshape(4, 4)
        return np.array(Trajectory([0.0], T[None]).T_wc[0])
    except (TypeError, ValueError) as error:
        raise format_error(name, "T_BS", f"expected a rigid 4x4 transform: {error}") from error


def _euroc_truth(base: Path) -> Trajectory | None:
    path = base / _TRUTH
    if not path.is_file():
        return None
    name, text = read_text(path)
    stamps: list[float] = []
    rows: list[list[float]] = []
    for line, content in data_lines(text):
        words = content.split(",")
        if len(words) < 8:
            reason = f"expected a stamp and 7 numbers, got {len(words)}"
            raise format_error(name, "", reason, line=line)
        stamps.append(_nanoseconds(words[0].strip(), name, line))
        rows.append(
            [
                number(word, file=name, line=line, field=field)
                for word, field in zip(words[1:8], _CSV_POSE, strict=True)
            ]
        )
        if len(stamps) > 1 and stamps[-1] <= stamps[-2]:
            raise format_error(name, "timestamp", "must be later than the one before", line=line)
        if abs(float(np.linalg.norm(rows[-1][3:])) - 1.0) > 1e-2:
            raise format_error(name, "quaternion", "a unit quaternion is expected", line=line)
    if not rows:
        raise format_error(name, "", "holds no pose")
    table = np.array(rows)
    body = Trajectory.from_quaternions(stamps, table[:, :3], table[:, [4, 5, 6, 3]])
    return Trajectory(body.timestamps, body.T_wc @ _body_to_sensor(base / "cam0" / "sensor.yaml"))
