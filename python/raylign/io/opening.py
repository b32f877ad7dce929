"""Open an image sequence of any known format."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from raylign._typing import PathLike
from raylign.errors import OptionsError
from raylign.io._folders import require_folder
from raylign.io._streams import format_error
from raylign.io.icl_nuim import looks_like_icl_nuim, read_icl_nuim
from raylign.io.image_folder import looks_like_image_folder, read_image_folder
from raylign.io.sequence import RgbdSequence
from raylign.io.seven_scenes import looks_like_seven_scenes, read_seven_scenes
from raylign.io.stereo import (
    looks_like_euroc,
    looks_like_stereo,
    read_euroc,
    read_stereo_pair,
)
from raylign.io.tum import looks_like_tum, read_tum_rgbd


class _Format(NamedTuple):
    looks_like: Callable[[Path], bool]
    read: Callable[..., RgbdSequence]
    sign: str


# In the order of asking: an ICL-NUIM folder also looks like TUM's, and a folder with a calibration
# of its own is described by it.
_FORMATS = {
    "icl_nuim": _Format(looks_like_icl_nuim, read_icl_nuim, "*.gt.freiburg"),
    "stereo": _Format(looks_like_stereo, read_stereo_pair, "left.png and disparity.png"),
    "folder": _Format(looks_like_image_folder, read_image_folder, "calibration.yaml"),
    "tum": _Format(looks_like_tum, read_tum_rgbd, "rgb.txt and depth.txt, or associations.txt"),
    "seven_scenes": _Format(looks_like_seven_scenes, read_seven_scenes, "frame-*.color.*"),
    "euroc": _Format(looks_like_euroc, read_euroc, "cam0/data.csv or mav0/cam0/data.csv"),
}

SEQUENCE_FORMATS = tuple(_FORMATS)


def open_sequence(path: PathLike, *, format: str = "auto", **options: Any) -> RgbdSequence:
    """Open a folder of images; what lies in it says which format it is.

    Args:
        path: folder of the sequence.
        format: `auto`, or one of `SEQUENCE_FORMATS`: `tum` (`read_tum_rgbd`), `icl_nuim`
            (`read_icl_nuim`), `seven_scenes` (`read_seven_scenes`), `euroc` (`read_euroc`),
            `stereo` (`read_stereo_pair`), `folder` (`read_image_folder`).
        **options: of that reader, e.g. `camera`, `depth_scale`, `time_offset_s`.

    Returns:
        RgbdSequence: frames in order of time, read when asked for.

    Raises:
        FormatError: the folder is missing or of no known format (the message lists what was looked
            for), or its reader refuses it.
        OptionsError: there is no format of that name, or an option is out of range.
        TypeError: the reader has no option of that name.
    """
    if format not in ("auto", *_FORMATS):
        raise OptionsError(f"format must be auto, {', '.join(_FORMATS)}, got {format!r}")
    root = require_folder(path)
    if format == "auto":
        format = next((name for name, f in _FORMATS.items() if f.looks_like(root)), "")
    if not format:
        signs = "; ".join(f"{name}: {f.sign}" for name, f in _FORMATS.items())
        raise format_error(str(root), "", f"is no image sequence; looked for {signs}")
    return _FORMATS[format].read(root, **options)
