"""Images that belong to a list of something else, poses for instance: found, counted, read."""

import glob
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from raylign._typing import AnyArray, PathLike
from raylign.io._folders import IMAGE_SUFFIXES, image_files, natural_key
from raylign.io._images import read_pixels
from raylign.io._streams import format_error

_MAX_NAMED = 3  # missing files in a message
_NUMBER = re.compile(r"\d+")


def read_image(path: PathLike) -> AnyArray:
    """Read an image file as raylign takes images.

    Args:
        path: PNG, JPEG, TIFF, PGM, … of 8 or 16 bits, or `.npy` with an (H, W) or (H, W, 3) array.

    Returns:
        (H, W) or (H, W, 3) RGB, uint8 or uint16; of `.npy` float32, too. Alpha is dropped, the
        orientation tag ignored: pixels are where the camera had them.

    Raises:
        FormatError: the file is missing, or no such image.
    """
    file = Path(path)
    if file.suffix != ".npy":
        return read_pixels(file)
    try:
        image = np.load(file, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise format_error(str(file), "", f"is no readable .npy file: {error}") from error
    is_image = isinstance(image, np.ndarray) and (image.ndim == 2 or image.shape[2:] == (3,))
    if not is_image or image.dtype not in (np.uint8, np.uint16, np.float32) or image.size == 0:
        found = getattr(image, "dtype", "?"), getattr(image, "shape", "?")
        raise format_error(str(file), "", f"is no image of uint8, uint16 or float32: {found}")
    return np.ascontiguousarray(image)


def list_images(source: PathLike | Iterable[PathLike], *, count: int | None = None) -> list[Path]:
    """Paths of images in the order of the numbers in their names.

    Args:
        source: a folder, whose images are taken; a glob pattern, e.g. `data/*.png`; or the paths
            themselves, whose order is kept.
        count: how many there must be.

    Returns:
        Paths: 2.png comes before 10.png.

    Raises:
        FormatError: a folder or file is missing, nothing matches, or there are not `count`; where
            the names are consecutive numbers, the message says which is missing.

    Example:
        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     for name in ("10.png", "2.png"):
        ...         pathlib.Path(folder, name).touch()
        ...     [path.name for path in list_images(folder, count=2)]
        ['2.png', '10.png']
    """
    if isinstance(source, str | Path) or hasattr(source, "__fspath__"):
        name = str(source)
        paths = _search(name)
    else:
        paths = [Path(path) for path in source]
        name = "list of images"
    for path in paths:
        if not path.is_file():
            raise format_error(str(path), "", "there is no such image")
    if count is not None and len(paths) != count:
        reason = f"{count} images expected but {len(paths)} found{_missing(paths)}"
        raise format_error(name, "", reason)
    return paths


def _search(name: str) -> list[Path]:
    if "\0" in name:
        raise ValueError("embedded null character in path")
    if Path(name).is_dir():
        return image_files(Path(name))
    if not glob.has_magic(name):
        raise format_error(name, "", "is no folder of images, and no pattern such as *.png")
    found = sorted((Path(path) for path in glob.glob(name)), key=natural_key)  # noqa: PTH207
    found = [path for path in found if path.suffix.lower() in (*IMAGE_SUFFIXES, ".npy")]
    if not found:
        raise format_error(name, "", "matches no image")
    return found


def _missing(paths: list[Path]) -> str:
    """What a sequence of numbered names lacks: `, 3.png is missing`."""
    numbered = {path.name: _NUMBER.findall(path.stem) for path in paths}
    if not paths or any(len(found) != 1 for found in numbered.values()):
        return ""
    numbers = {int(found[0]) for found in numbered.values()}
    if max(numbers) - min(numbers) > 2 * len(numbers):  # no consecutive names
        return ""
    gaps = sorted(set(range(min(min(numbers), 1), max(numbers) + 1)) - numbers)
    digits = numbered[paths[0].name][0]
    width = len(digits) if digits.startswith("0") else 1
    names = [paths[0].name.replace(digits, f"{gap:0{width}d}", 1) for gap in gaps]
    if not names:
        return ""
    more = f" and {len(names) - _MAX_NAMED} more" if len(names) > _MAX_NAMED else ""
    verb = "is" if len(names) == 1 else "are"
    return f", {', '.join(names[:_MAX_NAMED])}{more} {verb} missing"
