"""Download a data set, check it, and only then give it its name."""

import bz2
import contextlib
import hashlib
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

from raylign._typing import PathLike
from raylign.datasets.registry import BalEntry, find_bal
from raylign.errors import Error, FormatError, OptionsError

Progress = Callable[[int, int], None]  # bytes received, bytes expected (0: not known)

_CHUNK = 1 << 20
_TIMEOUT_S = 30.0  # without a byte; not for the whole file


class DownloadError(Error):
    """A file could not be fetched, or is not the one that the registry describes."""


def fetch(
    name: str,
    *,
    directory: PathLike = ".",
    mirror: str | None = None,
    progress: Progress | None = None,
) -> Path:
    """Download a BAL problem, verify it and unpack it as `<directory>/<name>.txt`.

    The file appears under its name only after its header counts and its sha256, or every number in
    it where the registry knows no sha256, have been checked. A failure leaves the directory as it
    was. A file that is already there and passes the checks is not fetched again.

    Args:
        name: `bal/problem-49-7776-pre` or `bal/ladybug-49`.
        directory: existing folder that receives the file.
        mirror: base URL that stands in for scheme and host of the registry's URL.
        progress: called with (bytes received, bytes expected or 0) while data arrives.

    Returns:
        Path of the text file.

    Raises:
        OptionsError: unknown name, or `mirror` is not http:// or https://.
        DownloadError: no connection, HTTP error, truncated or wrong content.
        OSError: the directory is missing or cannot be written.

    Example:
        >>> fetch("bal/ladybug-49", directory="bal")  # doctest: +SKIP
        PosixPath('bal/problem-49-7776-pre.txt')
    """
    entry = find_bal(name)
    folder = Path(directory)
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is not an existing folder")
    target = folder / f"{entry.name}.txt"
    if target.exists() and _is_good(target, entry):
        return target
    url = mirrored(entry.url, mirror)
    # Inside the folder, so that the last step is a rename within one file system.
    with tempfile.TemporaryDirectory(dir=folder, prefix=".raylign-download-") as scratch:
        archive = _retrieve(url, Path(scratch), progress)
        text = Path(scratch) / target.name
        _decompress(archive, text, url)
        verify(text, entry)
        text.replace(target)
    return target


def mirrored(url: str, mirror: str | None) -> str:
    """Replace scheme and host of `url` by the base URL `mirror`."""
    if mirror is None:
        return url
    if urlsplit(mirror).scheme not in ("http", "https"):
        raise OptionsError(f"the mirror must begin with http:// or https://, got '{mirror}'")
    return mirror.rstrip("/") + urlsplit(url).path


def verify(path: Path, entry: BalEntry) -> None:
    """Raise DownloadError unless the text file at `path` is the problem that `entry` describes."""
    _check_header(path, entry)
    if entry.sha256 is not None:
        digest = _sha256(path)
        if digest != entry.sha256:
            raise DownloadError(
                f"{path.name}: sha256 of the text is {digest}, the registry says {entry.sha256}"
            )
        return
    from raylign.io import read_bal  # without a checksum, every number is parsed

    try:
        read_bal(path, duplicates="keep")
    except FormatError as error:
        raise DownloadError(f"{path.name}: not a complete BAL file: {error}") from error


def _is_good(path: Path, entry: BalEntry) -> bool:
    try:
        verify(path, entry)
    except (DownloadError, OSError):
        return False
    return True


def _check_header(path: Path, entry: BalEntry) -> None:
    with path.open("rb") as stream:
        fields = stream.readline(200).split()
    expected = (entry.cameras, entry.points, entry.observations)
    names = ("cameras", "points", "observations")
    if len(fields) != 3 or not all(field.isdigit() for field in fields):
        raise DownloadError(f"{path.name}: the first line is not a BAL header")
    for count_name, field, count in zip(names, fields, expected, strict=True):
        if count is not None and int(field) != count:
            raise DownloadError(
                f"{path.name}: the header says {int(field)} {count_name}, the registry {count}"
            )


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _decompress(archive: Path, text: Path, url: str) -> None:
    with archive.open("rb") as stream:
        start = stream.read(40)
    if not start.startswith(b"BZh"):
        raise DownloadError(
            f"{url}: not a bzip2 file but something that begins with {start!r} (an error page?)"
        )
    try:
        with bz2.open(archive) as packed, text.open("wb") as out:
            shutil.copyfileobj(packed, out, _CHUNK)
    except EOFError as error:
        size = archive.stat().st_size
        raise DownloadError(f"{url}: truncated, the bzip2 data ends after {size} bytes") from error
    except OSError as error:
        if error.errno is not None:  # disk full and the like
            raise
        raise DownloadError(f"{url}: damaged bzip2 data: {error}") from error


class _PoochProgress:
    """The tqdm-like object that pooch drives, forwarding to a plain function."""

    def __init__(self, progress: Progress) -> None:
        self.total = 0
        self._received = 0
        self._progress = progress

    def update(self, count: int) -> None:
        self._received += count
        self._progress(self._received, self.total)

    def reset(self) -> None:
        self._received = 0

    def close(self) -> None:
        pass


@contextlib.contextmanager
def _quiet(logger: logging.Logger) -> Iterator[None]:
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        yield
    finally:
        logger.setLevel(level)


def _retrieve(url: str, folder: Path, progress: Progress | None) -> Path:
    import pooch  # slow to import: it brings requests
    import requests

    downloader = pooch.HTTPDownloader(
        progressbar=_PoochProgress(progress) if progress is not None else False,
        timeout=_TIMEOUT_S,
    )
    try:
        with _quiet(pooch.get_logger()):
            path = pooch.retrieve(
                url, known_hash=None, fname="archive", path=os.fspath(folder), downloader=downloader
            )
    except requests.HTTPError as error:
        answer = "an error" if error.response is None else error.response.status_code
        raise DownloadError(f"{url}: the server answered {answer}") from error
    except requests.exceptions.ChunkedEncodingError as error:
        raise DownloadError(f"{url}: the connection ended before the whole file arrived") from error
    except (requests.ConnectionError, requests.Timeout) as error:
        host = urlsplit(url).netloc
        raise DownloadError(f"could not reach {host}: {_root_cause(error)}") from error
    except (requests.RequestException, ValueError) as error:
        raise DownloadError(f"{url}: {error}") from error
    return Path(path)


def _root_cause(error: BaseException) -> str:
    """What the operating system said, from under the layers of requests and urllib3."""
    reason, cause = type(error).__name__, error.__context__
    while cause is not None:
        if isinstance(cause, OSError) and cause.strerror:
            reason = cause.strerror
        cause = cause.__cause__ or cause.__context__
    return "it did not answer in time" if "Timeout" in reason else reason
