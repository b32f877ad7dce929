"""TUM RGB-D and ICL-NUIM sequences: `rgb.txt`, `depth.txt`, `groundtruth.txt` or associations."""

import os
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from raylign._typing import F64, I32, PathLike
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.io._folders import check_positive, require_folder
from raylign.io._images import DepthCodec
from raylign.io._streams import format_error
from raylign.io._text import data_lines, number, read_text
from raylign.io.calibration import read_calibration
from raylign.io.sequence import Calibration, Camera, RgbdFrame, RgbdSequence, SequenceReport
from raylign.io.trajectory import read_tum_trajectory
from raylign.trajectory import associate, estimate_time_offset

DEPTH_SCALE = 5000.0  # of the 16-bit files, per m
CALIBRATION_FILE = "calibration.yaml"  # not of the benchmark: what TumSequenceWriter adds
ASSOCIATION_FILES = ("associations.txt", "associate.txt", "association.txt")
# Where the search for the lag starts. On fr1 depth stamps lie 15 ms before and 17 ms after those of
# the images; the later ones go with them (cv2.Odometry RGB-D on the strip of 37 frames: ATE 3.6 mm
# against 6.3; its depth-only path fits the truth best at stamps 15 ms earlier, its colour-only path
# at the stamps). Small enough that sensors in step (fr2, fr3) stay in step.
_DEPTH_IS_LATER_S = 0.008
_SIZE = (640, 480)
_IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")

# The calibration page of the benchmark: RGB cameras, and ROS' default for the rest.
_FREIBURG: dict[int, Camera] = {
    1: RadtanCamera(517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633),
    2: RadtanCamera(520.9, 521.0, 325.1, 249.7, 0.2312, -0.7849, -0.0033, -0.0001, 0.9172),
    3: PinholeCamera(535.4, 539.2, 320.1, 247.6),
}
_ROS_DEFAULT = PinholeCamera(525.0, 525.0, 319.5, 239.5)
_FREIBURG_NAME = re.compile(r"(?:freiburg|fr)([123])(?![0-9])", re.IGNORECASE)


def looks_like_tum(folder: Path) -> bool:
    """Whether the folder holds the lists of a TUM sequence, or at least its two image folders."""
    listed = (folder / "rgb.txt").is_file() and (folder / "depth.txt").is_file()
    associated = any((folder / name).is_file() for name in ASSOCIATION_FILES)
    return listed or associated or ((folder / "rgb").is_dir() and (folder / "depth").is_dir())


def read_tum_rgbd(
    folder: PathLike,
    *,
    camera: Camera | None = None,
    depth_scale: float = DEPTH_SCALE,
    time_offset_s: float | None = None,
    max_difference_s: float = 0.02,
) -> RgbdSequence:
    """Open a sequence of the TUM RGB-D benchmark.

    Pairs come from `associations.txt` if there is one, else from the stamps in `rgb.txt` and
    `depth.txt` (without these, the stamps in the file names of `rgb/` and `depth/`), one-to-one and
    in order. Images without depth, and the other way round, are left out and counted in `report`.

    Args:
        folder: holds the lists and the image folders.
        camera: overrides `calibration.yaml`, or where there is none the known intrinsics, chosen by
            `freiburg1` to `3` or `fr1` to `fr3` in the folder's name, or else in the first comment
            of `rgb.txt`; without these it is ROS' default, and `report.notices` says so.
        depth_scale: numbers of a depth file per m.
        time_offset_s: stamp of a depth image − stamp of its image, s; None: the lag about which
            the differences pile up (see `estimate_time_offset`); where they do twice, the depth
            images that come later, which is right on fr1.
        max_difference_s: largest difference of paired stamps, offset removed, s.

    Returns:
        RgbdSequence: truth from `groundtruth.txt` where there is one.

    Raises:
        FormatError: a list is missing or malformed, its stamps decrease, no image has depth near
            in time, or no listed file exists.
        OptionsError: a setting is out of range.

    Note: `camera` has the distortion of the benchmark's page for fr1 and fr2; most trackers use
    `sequence.pinhole` on the images as they are.
    """
    root = require_folder(folder)
    check_positive("depth_scale", depth_scale)
    lists = _read_lists(root, time_offset_s, max_difference_s)
    calibration = _calibration(root, camera)
    truth = root / "groundtruth.txt"
    notices = () if camera is not None else (calibration.source,)
    return RgbdSequence(
        lists.frames(root, DepthCodec(scale=depth_scale), _size_of(calibration)),
        format="tum",
        folder=root,
        calibration=calibration,
        truth=read_tum_trajectory(truth) if truth.is_file() else None,
        report=replace(lists.report, notices=notices),
    )


@dataclass
class _Lists:
    """Paired stamps and file names."""

    image_stamps: list[float] = field(default_factory=list)
    image_files: list[str] = field(default_factory=list)
    depth_stamps: list[float] = field(default_factory=list)
    depth_files: list[str] = field(default_factory=list)
    report: SequenceReport = field(default_factory=SequenceReport)

    def frames(self, root: Path, codec: DepthCodec, size: tuple[int, int]) -> list[RgbdFrame]:
        rows = zip(
            self.image_stamps, self.image_files, self.depth_stamps, self.depth_files, strict=True
        )
        return [
            RgbdFrame(i, t_image, root / image, root / depth, t_depth, codec, size)
            for i, (t_image, image, t_depth, depth) in enumerate(rows)
        ]


@dataclass
class _FileList:
    """One of `rgb.txt` and `depth.txt`, without doubles and files that are not there."""

    stamps: F64
    files: list[str]
    missing: list[str]
    num_duplicates: int


def _read_lists(root: Path, time_offset_s: float | None, max_difference_s: float) -> _Lists:
    for name in ASSOCIATION_FILES:
        if (root / name).is_file():
            return read_associations(root / name)
    images, depths = _file_list(root, "rgb"), _file_list(root, "depth")
    offset = time_offset_s
    if offset is None:
        offset = estimate_time_offset(images.stamps, depths.stamps, near_s=_DEPTH_IS_LATER_S)
    pairs = associate(
        images.stamps, depths.stamps, max_difference_s=max_difference_s, offset_s=offset
    )
    if len(pairs) == 0:
        reason = f"no depth image lies within {max_difference_s:g} s of an image"
        raise format_error(str(root), "", reason)
    return _paired(images, depths, pairs, offset)


def _paired(images: _FileList, depths: _FileList, pairs: I32, offset: float) -> _Lists:
    t_image, t_depth = images.stamps[pairs[:, 0]], depths.stamps[pairs[:, 1]]
    report = SequenceReport(
        num_images=len(images.stamps) + len(images.missing),
        num_depths=len(depths.stamps) + len(depths.missing),
        unpaired_images=tuple(np.delete(images.stamps, pairs[:, 0]).tolist()),
        unpaired_depths=tuple(np.delete(depths.stamps, pairs[:, 1]).tolist()),
        missing_files=(*images.missing, *depths.missing),
        num_duplicate_stamps=images.num_duplicates + depths.num_duplicates,
        time_offset_s=offset,
        max_difference_s=float(np.abs(t_image + offset - t_depth).max()),
    )
    return _Lists(
        t_image.tolist(),
        [images.files[i] for i in pairs[:, 0]],
        t_depth.tolist(),
        [depths.files[i] for i in pairs[:, 1]],
        report,
    )


def _file_list(root: Path, kind: str) -> _FileList:
    path = root / f"{kind}.txt"
    if not path.is_file() and (root / kind).is_dir():
        rows = _stamps_of_names(root, kind)
    else:
        rows = _rows_of_list(path)
    there = existing_files(root, [file for _, file in rows])
    stamps: list[float] = []
    files: list[str] = []
    missing = [file for _, file in rows if file not in there]
    num_duplicates = 0
    for stamp, file in rows:
        if stamps and stamp == stamps[-1]:
            num_duplicates += 1
        elif file in there:
            stamps.append(stamp)
            files.append(file)
    if not stamps:
        raise format_error(str(path), "", f"none of its {len(rows)} files exists")
    return _FileList(np.array(stamps), files, missing, num_duplicates)


def _rows_of_list(path: Path) -> list[tuple[float, str]]:
    name, text = read_text(path)
    rows: list[tuple[float, str]] = []
    for line, content in data_lines(text):
        stamp_text, _, file = content.partition(" ")
        file = file.strip()
        stamp = number(stamp_text, file=name, line=line, field="timestamp")
        if not file:
            raise format_error(name, "filename", "is missing", line=line)
        if rows and stamp < rows[-1][0]:
            reason = f"must not be earlier than the one before, {rows[-1][0]!r}, got {stamp!r}"
            raise format_error(name, "timestamp", reason, line=line)
        rows.append((stamp, file))
    if not rows:
        raise format_error(name, "", "lists no file")
    return rows


def _stamps_of_names(root: Path, kind: str) -> list[tuple[float, str]]:
    """Files whose whole stem is a stamp, e.g. `1305031102.175304.png`."""
    rows = []
    for path in (root / kind).iterdir():
        if path.suffix.lower() in _IMAGE_SUFFIXES and re.fullmatch(r"\d+(\.\d+)?", path.stem):
            rows.append((float(path.stem), f"{kind}/{path.name}"))
    if not rows:
        raise format_error(str(root / kind), "", "holds no image named by its time stamp")
    return sorted(rows)


def read_associations(path: Path) -> _Lists:
    """Pairs `stamp file stamp file` a line, colour first or (ICL-NUIM) depth first.

    Raises:
        FormatError: as `read_tum_rgbd`.
    """
    name, text = read_text(path)
    rows: list[tuple[float, str, float, str]] = []
    num_duplicates = 0
    for line, content in data_lines(text):
        tokens = content.split()
        if len(tokens) != 4:
            reason = f"expected `stamp file stamp file`, got {len(tokens)} words"
            raise format_error(name, "", reason, line=line)
        stamps = [number(t, file=name, line=line, field="timestamp") for t in tokens[::2]]
        first, second = (stamps[0], tokens[1]), (stamps[1], tokens[3])
        if _is_depth(tokens[1]) and not _is_depth(tokens[3]):
            first, second = second, first
        if rows and first[0] < rows[-1][0]:
            reason = f"must not be earlier than the one before, {rows[-1][0]!r}, got {first[0]!r}"
            raise format_error(name, "timestamp", reason, line=line)
        if rows and first[0] == rows[-1][0]:
            num_duplicates += 1
            continue
        rows.append((*first, *second))
    there = existing_files(path.parent, [f for row in rows for f in (row[1], row[3])])
    kept = [row for row in rows if row[1] in there and row[3] in there]
    if not kept:
        raise format_error(name, "", f"none of its {len(rows)} pairs of files exists")
    missing = tuple(f for row in rows for f in (row[1], row[3]) if f not in there)
    offsets = np.array([row[2] - row[0] for row in kept])
    report = SequenceReport(
        num_images=len(rows),
        num_depths=len(rows),
        missing_files=missing,
        num_duplicate_stamps=num_duplicates,
        time_offset_s=float(np.median(offsets)),
        max_difference_s=float(np.abs(offsets - np.median(offsets)).max()),
    )
    return _Lists(
        [row[0] for row in kept],
        [row[1] for row in kept],
        [row[2] for row in kept],
        [row[3] for row in kept],
        report,
    )


def existing_files(root: Path, names: list[str]) -> set[str]:
    """Which of the relative names exist: one listing per folder, not one look-up per file."""
    listings: dict[str, set[str]] = {}
    found = set()
    for name in names:
        folder, _, base = name.rpartition("/")
        if folder not in listings:
            path = root / folder
            listings[folder] = set(os.listdir(path)) if path.is_dir() else set()  # noqa: PTH208
        if base in listings[folder]:
            found.add(name)
    return found


def _is_depth(name: str) -> bool:
    return "depth" in name.lower()


def _calibration(root: Path, camera: Camera | None) -> Calibration:
    if camera is not None:
        return Calibration(camera, source="given by the caller")
    if (root / CALIBRATION_FILE).is_file():
        return read_calibration(root / CALIBRATION_FILE)
    place = "the folder's name"
    match = _FREIBURG_NAME.search(root.resolve().name)
    if match is None and (root / "rgb.txt").is_file():
        place = "a comment in rgb.txt"
        comments = [c for c in read_text(root / "rgb.txt")[1].splitlines() if c.startswith("#")]
        match = _FREIBURG_NAME.search(" ".join(comments))
    if match is None:
        source = (
            "assumed ROS' default intrinsics (525, 525, 319.5, 239.5): neither the folder's name "
            "nor rgb.txt says which camera this is; pass camera= if you know better"
        )
        return Calibration(_ROS_DEFAULT, *_SIZE, source=source)
    index = int(match[1])
    source = f"intrinsics of freiburg{index} (TUM RGB-D calibration), chosen by {place}"
    return Calibration(_FREIBURG[index], *_SIZE, source=source)


def _size_of(calibration: Calibration) -> tuple[int, int]:
    return calibration.width, calibration.height
