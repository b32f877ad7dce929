import io
import os
import zipfile

import numpy as np
import pytest

import raylign
from raylign.io import read_npz, write_npz
from tiny_problem import make_tiny_problem


class Unpickled:
    """Writes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def members() -> dict[str, np.ndarray]:
    return {
        "format": np.array("raylign.BalProblem"),
        "version": np.array(1, np.int64),
        **{name: np.array(value) for name, value in make_tiny_problem().to_dict().items()},
    }


def archive(**changes) -> io.BytesIO:
    stream = io.BytesIO()
    arrays = {name: value for name, value in (members() | changes).items() if value is not None}
    np.savez_compressed(stream, allow_pickle=True, **arrays)
    stream.seek(0)
    return stream


def raw_archive(name: str, data: bytes) -> io.BytesIO:
    """Archive in which one member is `data` instead of an array."""
    source = zipfile.ZipFile(archive())
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as target:
        for info in source.infolist():
            keep = source.read(info) if info.filename != f"{name}.npy" else data
            target.writestr(info.filename, keep)
    stream.seek(0)
    return stream


def npy_header(shape: str, dtype: str = "<f8") -> bytes:
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


def test_lossless(tmp_path):
    problem = make_tiny_problem().replace(colors=np.arange(60, dtype=np.uint8).reshape(20, 3))
    problem.points.flat[:5] = [np.nan, -0.0, 5e-324, np.inf, 1 / 3]
    path = tmp_path / "problem"  # no suffix is added
    write_npz(problem, path)
    assert list(tmp_path.iterdir()) == [path]
    assert read_npz(path) == problem
    assert read_npz(str(path)) == problem
    stream = io.BytesIO()
    write_npz(problem, stream)
    stream.seek(0)
    assert read_npz(stream) == problem


def test_numpy_reads_it(tmp_path):
    write_npz(make_tiny_problem(), tmp_path / "problem.npz")
    with np.load(tmp_path / "problem.npz") as arrays:
        assert str(arrays["format"]) == "raylign.BalProblem"
        assert int(arrays["version"]) == 1
        np.testing.assert_array_equal(arrays["points"], make_tiny_problem().points)


def test_reads_what_numpy_wrote():
    assert read_npz(archive()) == make_tiny_problem()


@pytest.mark.parametrize(
    ("changes", "field", "reason"),
    [
        *[({name: None}, name, "is missing") for name in members()],
        ({"format": np.array("raylign.BadProblem")}, "format", "'raylign.BadProblem'"),
        ({"format": np.array("other")}, "format", "expected dtype"),
        ({"version": np.array(2)}, "version", "got 2"),
        ({"version": np.array([1])}, "version", "wrong shape"),
        ({"cameras": np.zeros((4, 9), np.float32)}, "cameras", "float32"),
        ({"cameras": np.zeros((4, 8))}, "cameras", r"wrong shape \(4, 8\)"),
        ({"cameras": np.asfortranarray(np.zeros((4, 9)))}, "cameras", "Fortran order"),
        ({"camera_index": np.zeros(80, np.int64)}, "camera_index", "int64"),
        ({"point_index": np.full(80, 20, np.int32)}, "", "not in"),
        ({"point_index": np.full(80, -1, np.int32)}, "", "not in"),
        ({"point_index": np.zeros(79, np.int32)}, "", "79 rows"),
        ({"points": np.array([[1, 2, "x"]], object)}, "points", "object"),
        ({"points": np.zeros(20, [("x", "f8"), ("y", "f8")])}, "points", "dtype"),
    ],
)
def test_wrong_content(changes, field, reason):
    with pytest.raises(raylign.FormatError, match=reason) as caught:
        read_npz(archive(**changes))
    assert caught.value.field == field
    assert caught.value.file == "<stream>"
    assert caught.value.line == 0


def test_pickles_are_never_opened(tmp_path):
    trap = tmp_path / "trap"
    with pytest.raises(raylign.FormatError):
        read_npz(archive(points=np.array([Unpickled(trap)], object)))
    assert not trap.exists()


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"not a zip file",
        b"PK\x03\x04" + b"\0" * 100,
        b"PK\x05\x06" + b"\0" * 18,
        b"2 3 4\n0 0 1 1\n",
    ],
)
def test_not_an_archive(data):
    with pytest.raises(raylign.FormatError):
        read_npz(io.BytesIO(data))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"no array",
        npy_header("(3,"),
        npy_header("(20, 3)"),
        npy_header("(20, 3)") + b"\0" * 479,
        npy_header("(20, 3)") + b"\0" * 481,
        npy_header("(-20, 3)"),
        npy_header("(1000000000000, 3)") + b"\0" * 480,
        npy_header("(99999999999999999999999, 3)"),
        npy_header("(20, 3)", "|O") + b"cos\nsystem\n(S'true'\ntR.",
        npy_header("(20, 3)", "nonsense"),
    ],
)
def test_hostile_member(data):
    with pytest.raises(raylign.FormatError):
        read_npz(raw_archive("points", data))


def test_every_truncation_is_refused():
    data = archive().getvalue()
    for size in range(0, len(data), 7):
        with pytest.raises(raylign.FormatError):
            read_npz(io.BytesIO(data[:size]))


def test_damaged_bytes_are_refused_or_harmless():
    data = archive().getvalue()
    for position in range(0, len(data), 11):
        damaged = bytearray(data)
        damaged[position] ^= 0x55
        try:
            problem = read_npz(io.BytesIO(bytes(damaged)))
        except raylign.FormatError:
            continue
        assert problem == make_tiny_problem()  # a byte that carries nothing, as a time stamp


def test_paths(tmp_path):
    with pytest.raises(raylign.FormatError, match="cannot be opened: No such file"):
        read_npz(tmp_path / "missing.npz")
    with pytest.raises(raylign.FormatError, match="is a directory"):
        read_npz(tmp_path)
    with pytest.raises(raylign.FormatError, match="cannot be written: No such file"):
        write_npz(make_tiny_problem(), tmp_path / "missing" / "problem.npz")
    with pytest.raises(TypeError):
        read_npz(3)


def test_failure_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "problem.npz"
    path.write_text("old")

    def fail(*_args, **_kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(raylign.FormatError, match="cannot be written: No space left"):
        write_npz(make_tiny_problem(), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_broken_problem_is_refused(tmp_path):
    problem = make_tiny_problem()
    problem.point_index[0] = 99
    with pytest.raises(raylign.ShapeError):
        write_npz(problem, tmp_path / "problem.npz")
