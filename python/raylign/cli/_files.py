"""Reading and writing problems by suffix, and looking before the leap."""

import tempfile
from pathlib import Path

from raylign.cli._choices import Duplicates
from raylign.errors import OptionsError
from raylign.io import read_bal, read_npz, write_bal, write_npz, write_ply
from raylign.scene import BalProblem

BAL_SUFFIXES = (".txt", ".txt.gz", ".txt.bz2", ".bal", ".bal.gz", ".bal.bz2")
PLY_SUFFIXES = (".ply", ".ply.gz", ".ply.bz2")
WRITABLE_SUFFIXES = (*BAL_SUFFIXES, ".npz", *PLY_SUFFIXES)


def read_problem(path: Path, duplicates: Duplicates = Duplicates.ERROR) -> BalProblem:
    """Read a `.npz`, or anything else as BAL text (plain, gzip or bzip2)."""
    if path.suffix.lower() == ".npz":
        return read_npz(path, duplicates=duplicates.value)
    return read_bal(path, duplicates=duplicates.value)


def write_problem(problem: BalProblem, path: Path) -> str:
    """Write by suffix; the name appears when the content is complete.

    Returns:
        What to tell the user about it, e.g. ` (24 far points left out)`, or nothing.
    """
    check_problem_target(path)
    name = path.name.lower()
    if name.endswith(".npz"):
        write_npz(problem, path)
    elif name.endswith(PLY_SUFFIXES):
        num_far = write_ply(problem, path).num_far_points
        return f" ({num_far} far points left out)" if num_far else ""
    else:
        write_bal(problem, path)
    return ""


def check_distinct(source: Path | None, targets: list[Path | None]) -> None:
    """Refuse targets that would overwrite the input or each other, links followed.

    Raises:
        OptionsError: two of the files are one.
    """
    seen = {} if source is None else {source.resolve(): "the input"}
    for path in targets:
        if path is None:
            continue
        if path.resolve() in seen:
            raise OptionsError(f"{path} is the same file as {seen[path.resolve()]}")
        seen[path.resolve()] = "another output"


def check_problem_target(path: Path, suffixes: tuple[str, ...] = WRITABLE_SUFFIXES) -> None:
    """Raise now what writing `path` would raise after an hour of work.

    Raises:
        OptionsError: the suffix names no format.
        OSError: the folder is missing or refuses a file, or the name is a folder's.
    """
    if not path.name.lower().endswith(suffixes):
        raise OptionsError(f"{path}: the suffix must be one of {', '.join(suffixes)}")
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder, expected a file name")
    if not path.parent.is_dir():
        raise NotADirectoryError(f"the folder {path.parent} for {path.name} does not exist")
    _check_writable(path.parent)


def check_report_target(path: Path) -> None:
    """The same for a folder that will be created when missing."""
    existing = path
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        where = "it" if existing == path else str(existing)
        raise NotADirectoryError(f"no report can be written to {path}: {where} is not a folder")
    _check_writable(existing)


def _check_writable(folder: Path) -> None:
    """Create a file and remove it: permissions alone say little about /proc or a full disk."""
    try:
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".raylign-check-"):
            pass
    except OSError as error:
        raise type(error)(f"the folder {folder} is not writable: {error.strerror}") from error
