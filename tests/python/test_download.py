"""`datasets.fetch` against a server on localhost: what it refuses, and what it leaves behind."""

import bz2
import dataclasses
import functools
import hashlib
import http.server
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from raylign import OptionsError, cli, datasets
from raylign.cli import download as command
from raylign.datasets import download as module

ENTRY = datasets.find_bal("bal/ladybug-49")
URL_PATH = "/projects/bal/data/ladybug/problem-49-7776-pre.txt.bz2"

# Two cameras, three points, six observations; small, but every number of a BAL file is there.
TEXT = (
    "2 3 6\n"
    + "".join(
        f"{i} {j}     {10.0 * j - 5.0 * i:.6e} {3.0 * j:.6e}\n" for j in range(3) for i in range(2)
    )
    + "".join(f"{x}\n" for i in range(2) for x in (0, 0, 0, 0.1 * i, 0, 0, 500, 0, 0))
    + "".join(f"{x}\n" for j in range(3) for x in (0.1 * j, 0.0, -5.0))
).encode()


class Server:
    """Serves what `pages` holds; `short` bodies promise more bytes than they send."""

    def __init__(self) -> None:
        self.pages: dict[str, bytes] = {}
        self.missing_bytes = 0
        self.requests: list[str] = []
        handler = functools.partial(_Handler, self)
        self._http = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self.url = f"http://127.0.0.1:{self._http.server_port}"
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.01,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()


class _Handler(http.server.BaseHTTPRequestHandler):
    def __init__(self, server: Server, *args: object) -> None:
        self._state = server
        super().__init__(*args)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        self._state.requests.append(self.path)
        body = self._state.pages.get(self.path)
        if body is None:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Length", str(len(body) + self._state.missing_bytes))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *args: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[Server]:
    instance = Server()
    yield instance
    instance.close()


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> datasets.BalEntry:
    """The ladybug entry, but describing TEXT."""
    entry = dataclasses.replace(
        ENTRY, cameras=2, points=3, observations=6, sha256=hashlib.sha256(TEXT).hexdigest()
    )
    monkeypatch.setattr(module, "find_bal", lambda name: entry)
    return entry


def fetch(server: Server, folder: Path) -> Path:
    return datasets.fetch("bal/ladybug-49", directory=folder, mirror=server.url)


def test_good_file_arrives_unpacked(
    server: Server, small: datasets.BalEntry, tmp_path: Path
) -> None:
    server.pages[URL_PATH] = bz2.compress(TEXT)
    path = fetch(server, tmp_path)
    assert path == tmp_path / "problem-49-7776-pre.txt"
    assert path.read_bytes() == TEXT
    assert list(tmp_path.iterdir()) == [path]
    assert server.requests == [URL_PATH]


def test_good_file_is_not_fetched_again(
    server: Server, small: datasets.BalEntry, tmp_path: Path
) -> None:
    server.pages[URL_PATH] = bz2.compress(TEXT)
    fetch(server, tmp_path)
    fetch(server, tmp_path)
    assert len(server.requests) == 1


def test_progress_ends_at_the_size(
    server: Server, small: datasets.BalEntry, tmp_path: Path
) -> None:
    packed = bz2.compress(TEXT)
    server.pages[URL_PATH] = packed
    seen: list[tuple[int, int]] = []
    datasets.fetch(
        "x", directory=tmp_path, mirror=server.url, progress=lambda *pair: seen.append(pair)
    )
    assert seen[-1] == (len(packed), len(packed))


def test_mirror_may_have_a_path(server: Server, small: datasets.BalEntry, tmp_path: Path) -> None:
    server.pages["/copy" + URL_PATH] = bz2.compress(TEXT)
    datasets.fetch("x", directory=tmp_path, mirror=server.url + "/copy/")
    assert server.requests == ["/copy" + URL_PATH]


PACKED = bz2.compress(TEXT)
WRONG = {
    "http 404": (None, "404"),
    "truncated archive": (PACKED[: len(PACKED) // 2], "truncated"),
    "empty": (b"", "not a bzip2 file"),
    "error page": (b"<!DOCTYPE html><title>Sorry</title>", "not a bzip2 file"),
    "damaged archive": (PACKED[:20] + b"\0\0\0\0\0\0" + PACKED[26:], "damaged"),
    "other text": (bz2.compress(b"hello\n"), "not a BAL header"),
    "wrong cameras": (bz2.compress(TEXT.replace(b"2 3 6", b"4 3 6", 1)), "4 cameras"),
    "wrong points": (bz2.compress(TEXT.replace(b"2 3 6", b"2 5 6", 1)), "5 points"),
    "wrong observations": (bz2.compress(TEXT.replace(b"2 3 6", b"2 3 7", 1)), "7 observations"),
    "one digit changed": (bz2.compress(TEXT.replace(b"500", b"501")), "sha256"),
    "text cut short": (bz2.compress(TEXT[:-5]), "sha256"),
}


@pytest.mark.parametrize("existing", [None, b"mine"], ids=["fresh", "over a file of the user's"])
@pytest.mark.parametrize("case", WRONG)
def test_wrong_download_leaves_nothing_behind(
    server: Server,
    small: datasets.BalEntry,
    tmp_path: Path,
    case: str,
    existing: bytes | None,
) -> None:
    body, message = WRONG[case]
    target = tmp_path / "problem-49-7776-pre.txt"
    if existing is not None:
        target.write_bytes(existing)
    if body is not None:
        server.pages[URL_PATH] = body
    with pytest.raises(datasets.DownloadError, match=message):
        fetch(server, tmp_path)
    if existing is None:
        assert list(tmp_path.iterdir()) == []
    else:
        assert list(tmp_path.iterdir()) == [target]
        assert target.read_bytes() == existing


def test_short_body_is_refused(server: Server, small: datasets.BalEntry, tmp_path: Path) -> None:
    server.pages[URL_PATH] = PACKED
    server.missing_bytes = 100
    with pytest.raises(datasets.DownloadError, match=r"ended before|truncated"):
        fetch(server, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_without_checksum_every_number_is_read(
    server: Server, small: datasets.BalEntry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = dataclasses.replace(small, sha256=None)
    monkeypatch.setattr(module, "find_bal", lambda name: entry)
    server.pages[URL_PATH] = bz2.compress(TEXT[:-5])
    with pytest.raises(datasets.DownloadError, match="not a complete BAL file"):
        fetch(server, tmp_path)
    assert list(tmp_path.iterdir()) == []
    server.pages[URL_PATH] = PACKED
    assert fetch(server, tmp_path).read_bytes() == TEXT


def test_bad_existing_file_is_replaced(
    server: Server, small: datasets.BalEntry, tmp_path: Path
) -> None:
    server.pages[URL_PATH] = PACKED
    (tmp_path / "problem-49-7776-pre.txt").write_bytes(TEXT[:50])
    assert fetch(server, tmp_path).read_bytes() == TEXT


def test_no_server(small: datasets.BalEntry, tmp_path: Path) -> None:
    with pytest.raises(
        datasets.DownloadError, match=r"^could not reach 127\.0\.0\.1:1: Connection refused$"
    ):
        datasets.fetch("x", directory=tmp_path, mirror="http://127.0.0.1:1")
    assert list(tmp_path.iterdir()) == []


def test_arguments(tmp_path: Path) -> None:
    with pytest.raises(OptionsError, match=r"no data set 'bal/ladybag-49'.*bal/ladybug-49"):
        datasets.fetch("bal/ladybag-49", directory=tmp_path)
    with pytest.raises(NotADirectoryError):
        datasets.fetch("bal/ladybug-49", directory=tmp_path / "none")
    with pytest.raises(OptionsError, match="http"):
        datasets.fetch("bal/ladybug-49", directory=tmp_path, mirror="ftp://somewhere")


def test_registry_is_sound() -> None:
    entries = datasets.bal_entries()
    assert len(entries) > 90
    assert len({entry.name for entry in entries}) == len(entries)
    assert len({entry.alias for entry in entries}) == len(entries)
    for entry in entries:
        assert entry.name == f"problem-{entry.cameras}-{entry.points}-pre"
        assert entry.url.endswith(f"/{entry.scene}/{entry.name}.txt.bz2")
        assert entry.sha256 is None or len(entry.sha256) == 64
        for name in (entry.name, entry.alias, f"bal/{entry.name}", f"bal/{entry.alias}"):
            assert datasets.find_bal(name) is entry


@pytest.mark.data
@pytest.mark.parametrize("name", ["problem-49-7776-pre", "problem-21-11315-pre"])
def test_registry_describes_the_real_files(name: str, shared_data: Path) -> None:
    module.verify(shared_data / "bal" / f"{name}.txt", datasets.find_bal(name))


def test_command_line(server: Server, small: datasets.BalEntry, tmp_path: Path) -> None:
    arguments = ["download", "bal/ladybug-49", "-o", str(tmp_path), "--mirror", server.url]
    missing = CliRunner().invoke(cli.app, arguments)
    assert missing.exit_code == 1
    assert "404" in missing.stderr
    assert "Traceback" not in missing.stderr
    server.pages[URL_PATH] = PACKED
    good = CliRunner().invoke(cli.app, arguments)
    assert good.exit_code == 0, good.output
    assert "problem-49-7776-pre.txt" in good.stdout


def test_one_failure_does_not_keep_the_others_from_coming(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fake(name: str, **words: object) -> Path:
        if name == "problem-49-7776-pre":
            raise datasets.DownloadError("no such thing")
        return tmp_path / f"{name}.txt"

    monkeypatch.setattr(command, "fetch", fake)
    result = CliRunner().invoke(cli.app, ["download", "ladybug-49", "ladybug-73"])
    assert result.exit_code == 1
    assert result.stderr == "error: no such thing\n"
    assert "problem-73-11032-pre.txt" in result.stdout


@pytest.mark.parametrize("columns", [None, "60"])
def test_names_in_the_list_are_whole(columns: str | None) -> None:
    shown = CliRunner().invoke(cli.app, ["download", "--list"], env={"COLUMNS": columns}).stdout
    assert "…" not in shown
    for entry in datasets.bal_entries():
        assert f"bal/{entry.alias} " in shown
        assert entry.name in shown


def test_command_line_list_and_usage() -> None:
    listed = CliRunner().invoke(cli.app, ["download", "--list"], env={"COLUMNS": "120"})
    assert listed.exit_code == 0
    for entry in datasets.bal_entries():
        assert f"bal/{entry.alias} " in listed.stdout
    assert CliRunner().invoke(cli.app, ["download"]).exit_code == 2
    mirror = ["download", "ladybug-49", "--mirror", "ftp://somewhere"]
    assert CliRunner().invoke(cli.app, mirror).exit_code == 2
    assert CliRunner().invoke(cli.app, ["download", "bal/nothing"]).exit_code == 2
