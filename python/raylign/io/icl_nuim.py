"""ICL-NUIM sequences in their TUM-compatible form: `associations.txt` and `*.gt.freiburg`."""

from dataclasses import replace
from pathlib import Path

from raylign._typing import PathLike
from raylign.camera import PinholeCamera
from raylign.io._folders import check_positive, require_folder
from raylign.io._images import DepthCodec
from raylign.io._streams import format_error
from raylign.io.sequence import Calibration, Camera, RgbdSequence
from raylign.io.trajectory import read_tum_trajectory
from raylign.io.tum import ASSOCIATION_FILES, DEPTH_SCALE, read_associations

# The data set's page: fy = −480, the y axis points up. Upside down, rows run along +y.
_CAMERA = PinholeCamera(481.2, 480.0, 319.5, 239.5)
_SIZE = (640, 480)
_TRUTH = "*.gt.freiburg"


def looks_like_icl_nuim(folder: Path) -> bool:
    """Whether the folder holds an ICL-NUIM trajectory."""
    return any(folder.glob(_TRUTH))


def read_icl_nuim(
    folder: PathLike, *, camera: Camera | None = None, depth_scale: float = DEPTH_SCALE
) -> RgbdSequence:
    """Open an ICL-NUIM sequence (living room or office, "TUM RGB-D compatible PNGs").

    The data set's camera has its y axis up and fy = −480. **Images and depth are turned upside
    down**, so that the camera obeys raylign's convention (y down, fy > 0) and poses keep the
    numbers of the file: trajectories can be compared with it as they are. As the data set's world
    is left-handed, a point cloud made of them is mirrored, like the data set's own.

    Args:
        folder: holds `associations.txt`, the image folders and `*.gt.freiburg`.
        camera: of the turned images; overrides the data set's (481.2, 480, 319.5, 239.5).
        depth_scale: numbers of a depth file per m.

    Returns:
        RgbdSequence: stamps are those of the files, which count frames (30 per second).

    Raises:
        FormatError: a list is missing or malformed, there are several truths, or no listed file
            exists.
        OptionsError: a setting is out of range.
    """
    root = require_folder(folder)
    check_positive("depth_scale", depth_scale)
    lists = [root / name for name in ASSOCIATION_FILES if (root / name).is_file()]
    if not lists:
        raise format_error(str(root), "", f"holds none of {', '.join(ASSOCIATION_FILES)}")
    truths = sorted(root.glob(_TRUTH))
    if len(truths) > 1:
        names = ", ".join(path.name for path in truths)
        raise format_error(str(root), "", f"holds several trajectories: {names}")
    pairs = read_associations(lists[0])
    calibration = Calibration(camera or _CAMERA, *_SIZE, source="intrinsics of ICL-NUIM")
    codec = DepthCodec(scale=depth_scale, flip=True)
    notice = "images and depth are turned upside down, because the data set's y axis points up"
    return RgbdSequence(
        pairs.frames(root, codec, _SIZE if camera is None else (0, 0)),
        format="icl_nuim",
        folder=root,
        calibration=calibration,
        truth=read_tum_trajectory(truths[0]) if truths else None,
        report=replace(pairs.report, notices=(notice,)),
    )
