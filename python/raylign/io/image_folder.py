"""Plain folders of images and depth images with a YAML calibration."""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from raylign._typing import PathLike
from raylign.camera import PinholeCamera
from raylign.io._folders import (
    DEPTH_SUFFIXES,
    StampedFile,
    check_positive,
    image_files,
    read_stamps,
    require_folder,
    stamp_of_name,
)
from raylign.io._images import DepthCodec
from raylign.io._streams import format_error
from raylign.io.calibration import load_yaml, read_calibration
from raylign.io.sequence import Calibration, Camera, RgbdFrame, RgbdSequence, SequenceReport
from raylign.io.trajectory import read_tum_trajectory
from raylign.trajectory import associate, estimate_time_offset

CALIBRATION_FILES = ("calibration.yaml", "calibration.yml", "camera.yaml", "camera_info.yaml")
_IMAGE_FOLDERS = ("rgb", "color", "image", "images", "left", "image_0", "image_2")
_DEPTH_FOLDERS = ("depth", "depths")


@dataclass(frozen=True)
class _Layout:
    """The `sequence:` part of a calibration file."""

    images: str = ""
    depth: str = ""
    disparity: str = ""
    depth_scale: float = 1000.0
    max_depth: float = np.inf
    rate_hz: float = 30.0
    timestamps: str = ""
    truth: str = ""


def looks_like_image_folder(folder: Path) -> bool:
    """Whether there is a calibration file."""
    return any((folder / name).is_file() for name in CALIBRATION_FILES)


def read_image_folder(
    folder: PathLike,
    *,
    camera: Camera | None = None,
    calibration: PathLike | None = None,
    depth_scale: float | None = None,
    rate_hz: float | None = None,
    max_difference_s: float = 0.02,
) -> RgbdSequence:
    """Open images, and depth or disparity images, described by a YAML file.

    The file holds the camera (see `read_calibration`; any of its kinds) and, optionally, a mapping
    `sequence:` with `images`, `depth` or `disparity` (folders), `depth_scale` (numbers per m;
    default 1000), `max_depth` (m), `rate_hz` (default 30), `timestamps` (file, one stamp in s a
    line) and `truth` (TUM trajectory), all relative to the folder. Without it: images in the first
    of `rgb`, `color`, `image`, `images`, `left`, `image_0`, `image_2`, depth in `depth`.

    An image and a depth image belong together when their names' stems are equal; or, if none are,
    when their stamps in the names are associated; or, if there are none, by order, when there are
    equally many.

    Args:
        folder: holds the image folders.
        camera: overrides the file's.
        calibration: the file; default: `calibration.yaml` (or `camera.yaml`, `camera_info.yaml`)
            in the folder.
        depth_scale: overrides the file's; integer files only, float files are in m.
        rate_hz: overrides the file's; used where neither names nor a list give stamps.
        max_difference_s: largest difference of associated stamps, s.

    Raises:
        FormatError: a folder or file is missing or malformed, or images and depth cannot be paired.
        OptionsError: a setting is out of range.
    """
    root = require_folder(folder)
    file = _calibration_file(root, calibration)
    if camera is not None:
        found = Calibration(camera, source="given by the caller")
    elif file is not None:
        found = read_calibration(file)
    else:
        reason = f"holds none of {', '.join(CALIBRATION_FILES)}, and no camera= was given"
        raise format_error(str(root), "", reason)
    layout = _Layout() if file is None else _read_layout(file)
    if depth_scale is not None:
        layout = replace(layout, depth_scale=depth_scale)
    if rate_hz is not None:
        layout = replace(layout, rate_hz=rate_hz)
    check_positive("depth_scale", layout.depth_scale)
    check_positive("rate_hz", layout.rate_hz)
    images = _stamped(root, _image_folder(root, layout), layout)
    depth_folder = _depth_folder(root, layout)
    pairs, report = _pair(root, images, depth_folder, max_difference_s)
    size = (found.width, found.height)
    codec = _codec(root, found, layout)
    truth = root / layout.truth if layout.truth else None
    return RgbdSequence(
        [
            RgbdFrame(
                i,
                image.stamp,
                image.path,
                None if depth is None else depth.path,
                None if depth is None else depth.stamp,
                codec,
                size,
            )
            for i, (image, depth) in enumerate(pairs)
        ],
        format="folder",
        folder=root,
        calibration=found,
        truth=None if truth is None else read_tum_trajectory(truth),
        report=replace(report, notices=(found.source,)),
    )


def _calibration_file(root: Path, given: PathLike | None) -> Path | None:
    if given is not None:
        return Path(given)
    return next((root / name for name in CALIBRATION_FILES if (root / name).is_file()), None)


def _read_layout(file: Path) -> _Layout:
    name, node = load_yaml(file)
    given = node.get("sequence", {})
    if not isinstance(given, dict):
        raise format_error(name, "sequence", "expected a mapping")
    defaults = vars(_Layout())
    values: dict[str, Any] = {}
    for key, value in given.items():
        if key not in defaults:
            reason = f"is no field; these are: {', '.join(defaults)}"
            raise format_error(name, f"sequence.{key}", reason)
        kind = type(defaults[key])
        try:
            values[key] = kind(value)
        except (TypeError, ValueError):
            reason = f"expected a {'number' if kind is float else 'name'}"
            raise format_error(name, f"sequence.{key}", reason) from None
        if kind is float and not values[key] > 0.0:
            raise format_error(name, f"sequence.{key}", f"must be > 0, got {value}")
    if values.get("depth") and values.get("disparity"):
        raise format_error(name, "sequence.disparity", "give depth or disparity, not both")
    return _Layout(**values)


def _image_folder(root: Path, layout: _Layout) -> Path:
    names = [layout.images] if layout.images else _IMAGE_FOLDERS
    for name in names:
        if (root / name).is_dir():
            return root / name
    raise format_error(str(root), "", f"holds no folder {', '.join(names)} with the images")


def _depth_folder(root: Path, layout: _Layout) -> Path | None:
    named = layout.depth or layout.disparity
    for name in [named] if named else _DEPTH_FOLDERS:
        if (root / name).is_dir():
            return root / name
    if named:
        raise format_error(str(root / named), "", "is no folder")
    return None


def _codec(root: Path, calibration: Calibration, layout: _Layout) -> DepthCodec:
    if not layout.disparity:
        return DepthCodec(scale=layout.depth_scale, max_depth=layout.max_depth)
    if calibration.baseline == 0.0:
        raise format_error(str(root), "camera.baseline", "is missing: disparity gives no depth")
    if not isinstance(calibration.camera, PinholeCamera):
        raise format_error(str(root), "camera.distortion", "disparity needs rectified images")
    fb = calibration.camera.fx * calibration.baseline
    return DepthCodec(scale=0.0, disparity_fb=fb, max_depth=layout.max_depth)


def _stamped(root: Path, folder: Path, layout: _Layout) -> list[StampedFile]:
    """Images with stamps, from the list, the names, or the rate."""
    files = image_files(folder)
    if layout.timestamps:
        stamps = read_stamps(root / layout.timestamps)
        if len(stamps) != len(files):
            reason = f"holds {len(stamps)} stamps for {len(files)} images in {folder.name}"
            raise format_error(str(root / layout.timestamps), "", reason)
    else:
        stamps = [stamp_of_name(path) for path in files]
        if not np.isfinite(stamps).all():
            stamps = [i / layout.rate_hz for i in range(len(files))]
    rows = sorted(zip(stamps, files, strict=True))
    for (before, _), (stamp, path) in pairwise(rows):
        if stamp == before:
            raise format_error(str(path), "timestamp", "is that of another image too")
    return [StampedFile(path, stamp) for stamp, path in rows]


Pairs = list[tuple[StampedFile, StampedFile | None]]


def _pair(
    root: Path, images: list[StampedFile], folder: Path | None, max_difference_s: float
) -> tuple[Pairs, SequenceReport]:
    if folder is None:
        return [(image, None) for image in images], SequenceReport(num_images=len(images))
    files = image_files(folder, DEPTH_SUFFIXES)
    depths = [StampedFile(path, stamp_of_name(path)) for path in files]
    by_stem = {depth.path.stem: depth for depth in depths}
    offset = 0.0
    pairs: Pairs
    if any(image.path.stem in by_stem for image in images):
        pairs = [
            (image, replace(by_stem[image.path.stem], stamp=image.stamp))
            for image in images
            if image.path.stem in by_stem
        ]
    elif all(np.isfinite(depth.stamp) for depth in depths):
        pairs, offset = _associated(images, depths, max_difference_s)
    elif len(images) == len(depths):
        pairs = [
            (image, replace(depth, stamp=image.stamp))
            for image, depth in zip(images, depths, strict=True)
        ]
    else:
        pairs = []
    if not pairs:
        reason = (
            f"{len(images)} images and {len(depths)} depth images share neither names nor stamps"
        )
        raise format_error(str(root), "", reason)
    used = {image.path for image, _ in pairs}, {depth.path for _, depth in pairs if depth}
    report = SequenceReport(
        num_images=len(images),
        num_depths=len(depths),
        unpaired_images=tuple(image.stamp for image in images if image.path not in used[0]),
        unpaired_depths=tuple(depth.stamp for depth in depths if depth.path not in used[1]),
        time_offset_s=offset,
    )
    return pairs, report


def _associated(
    images: list[StampedFile], depths: list[StampedFile], max_difference_s: float
) -> tuple[Pairs, float]:
    first = [image.stamp for image in images]
    second = [depth.stamp for depth in depths]
    offset = estimate_time_offset(first, second)
    indices = associate(first, second, max_difference_s=max_difference_s, offset_s=offset)
    return [(images[i], depths[j]) for i, j in indices.tolist()], offset
