"""What the readers of image folders share."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raylign._typing import PathLike
from raylign.errors import OptionsError
from raylign.io._streams import format_error
from raylign.io._text import data_lines, number, read_text

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".webp")
DEPTH_SUFFIXES = (".png", ".tif", ".tiff", ".pfm", ".exr", ".pgm", ".npy")
_SECONDS = re.compile(r"\d+\.\d+")
_NANOSECONDS = re.compile(r"\d{18,19}")


@dataclass(frozen=True)
class StampedFile:
    """A file with its stamp in s; NaN where neither the name nor a list gives one."""

    path: Path
    stamp: float


def require_folder(folder: PathLike) -> Path:
    """The folder as a path.

    Raises:
        FormatError: there is none.
    """
    root = Path(folder)
    if not root.is_dir():
        raise format_error(str(root), "", "is no folder")
    return root


def check_positive(name: str, value: float) -> None:
    """Raise OptionsError unless the number is finite and > 0."""
    if not 0.0 < value < np.inf:
        raise OptionsError(f"{name} must be finite and > 0, got {value}")


def image_files(folder: Path, suffixes: tuple[str, ...] = IMAGE_SUFFIXES) -> list[Path]:
    """Files of a folder by suffix, in the order of the numbers in their names.

    Raises:
        FormatError: there is none.
    """
    found = [path for path in folder.iterdir() if path.suffix.lower() in suffixes]
    if not found:
        raise format_error(str(folder), "", f"holds no image ({', '.join(suffixes)})")
    return sorted(found, key=natural_key)


def natural_key(path: Path) -> list[tuple[int, int, str]]:
    """Sorts frame2 before frame10."""
    parts = re.split(r"(\d+)", path.name)
    return [(1, int(p), p) if p.isdecimal() else (0, 0, p) for p in parts]


def stamp_of_name(path: Path) -> float:
    """Seconds in a name like `1305031102.175304.png`, or nanoseconds in 18 or 19 digits; or NaN."""
    if _SECONDS.fullmatch(path.stem):
        return float(path.stem)
    if _NANOSECONDS.fullmatch(path.stem):
        return int(path.stem) / 1e9
    return np.nan


def read_stamps(path: Path) -> list[float]:
    """One stamp in s per line (more words are ignored), strictly increasing.

    Raises:
        FormatError: a line is no number, or not later than the one before.
    """
    name, text = read_text(path)
    stamps: list[float] = []
    for line, content in data_lines(text):
        stamp = number(content.split()[0], file=name, line=line, field="timestamp")
        if stamps and stamp <= stamps[-1]:
            reason = f"must be later than the one before, {stamps[-1]!r}, got {stamp!r}"
            raise format_error(name, "timestamp", reason, line=line)
        stamps.append(stamp)
    return stamps
