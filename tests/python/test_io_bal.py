import bz2
import contextlib
import gzip
import io
import locale
import os
import re
import resource
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign.io import read_bal, write_bal
from tiny_problem import make_tiny_problem

# Two cameras, three points, four observations. Lines: 1 header, 2-5 observations, 6-23 cameras,
# 24-32 points; every malformed case below is this text with one thing broken.
VALID = textwrap.dedent("""\
    2 3 4
    0 0     -1.5 2.5
    1 0     3 4e1
    0 1     5.25 -6
    1 2     7 8
    """) + "".join(
    f"{value}\n"
    for value in [
        *(0.1, 0.2, 0.3, 1.0, 2.0, 3.0, 500.0, -1e-7, 1e-13),
        *(0.4, 0.5, 0.6, 4.0, 5.0, 6.0, 600.0, 0.0, -0.0),
        *(1, 2, 3, 4, 5, 6, 7, 8, 9),
    ]
)


def line_replaced(line: int, new: str) -> bytes:
    lines = VALID.splitlines()
    lines[line - 1] = new
    return ("\n".join(lines) + "\n").encode()


def lines_kept(count: int, tail: str = "") -> bytes:
    return ("\n".join(VALID.splitlines()[:count]) + "\n" + tail).encode()


def error_of(data: bytes, **options: str) -> raylign.FormatError:
    with pytest.raises(raylign.FormatError) as caught:
        read_bal(io.BytesIO(data), **options)
    assert isinstance(caught.value, ValueError)
    assert str(caught.value).startswith("<stream>")
    return caught.value


@pytest.fixture
def umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


class TestRead:
    def test_values(self):
        problem = read_bal(io.BytesIO(VALID.encode()))
        np.testing.assert_array_equal(problem.camera_index, [0, 1, 0, 1])
        np.testing.assert_array_equal(problem.point_index, [0, 0, 1, 2])
        np.testing.assert_array_equal(
            problem.observations, [[-1.5, 2.5], [3, 40], [5.25, -6], [7, 8]]
        )
        np.testing.assert_array_equal(
            problem.cameras[0], [0.1, 0.2, 0.3, 1.0, 2.0, 3.0, 500.0, -1e-7, 1e-13]
        )
        np.testing.assert_array_equal(problem.points, np.arange(1.0, 10.0).reshape(3, 3))
        assert problem.colors.shape == (0, 3)

    @pytest.mark.parametrize(
        "text",
        [
            VALID.replace("\n", "\r\n"),
            VALID.replace("\n", " "),
            VALID.replace("\n", "\n\n  \t\n"),
            VALID.replace(" ", "\t\v\f "),
            VALID.rstrip("\n"),
            "\n\n" + VALID + "\n \n",
            VALID.replace("\n7\n", "\n+7\n"),
            VALID.replace("\n7\n", "\n7.\n"),
            VALID.replace("\n7\n", "\n.7E+1\n"),
            VALID.replace("\n7\n", "\n007.0000000000000000000000000000\n"),
        ],
        ids=[
            "crlf", "one line", "blank lines", "tabs", "no final newline", "outer blanks",
            "plus sign", "bare point", "leading point", "leading zeros",
        ],
    )  # fmt: skip
    def test_spelling_does_not_matter(self, text):
        assert read_bal(io.BytesIO(text.encode())) == read_bal(io.BytesIO(VALID.encode()))

    @pytest.mark.parametrize(
        ("text", "value"),
        [
            ("-0.0", -0.0),
            ("4.9406564584124654e-324", 5e-324),
            ("2.2250738585072011e-308", 2.2250738585072011e-308),
            ("1.7976931348623157e308", sys.float_info.max),
            ("1e-999", 0.0),
            ("-1e-999", -0.0),
            ("0." + "0" * 400 + "1", 0.0),
            ("0.1" + "0" * 900, 0.1),
            ("9007199254740993", 9007199254740992.0),
            ("0.1000000000000000055511151231257827021181583404541015625", 0.1),
        ],
    )
    def test_numbers_are_correctly_rounded(self, text, value):
        problem = read_bal(io.BytesIO(line_replaced(24, text)))
        assert problem.points[0, 0].tobytes() == np.float64(value).tobytes()

    @pytest.mark.parametrize("as_type", [str, lambda path: path], ids=["str", "Path"])
    def test_paths(self, tmp_path, as_type):
        path = tmp_path / "ä problem.txt"
        path.write_text(VALID)
        assert read_bal(as_type(path)).num_points == 3

    def test_pipe(self, tmp_path):
        path = tmp_path / "pipe"
        os.mkfifo(path)
        writer = threading.Thread(target=path.write_text, args=(VALID,))
        writer.start()
        assert read_bal(path) == read_bal(io.BytesIO(VALID.encode()))
        writer.join()

    def test_buffer_boundaries(self, tmp_path):
        # Larger than the reader's buffer by far: tokens fall across every refill.
        rng = np.random.default_rng(3)
        problem = make_tiny_problem()
        problem = problem.replace(
            camera_index=rng.integers(0, 4, 30_000, dtype=np.int32),
            point_index=rng.integers(0, 20, 30_000, dtype=np.int32),
            observations=rng.normal(size=(30_000, 2)),
        )
        for suffix in ["", ".gz", ".bz2"]:
            path = tmp_path / f"large.txt{suffix}"
            write_bal(problem, path)
            assert read_bal(path, duplicates="keep") == problem

    @pytest.mark.data
    @pytest.mark.parametrize(
        ("name", "counts"),
        [
            ("problem-49-7776-pre.txt", (49, 7776, 31843)),
            ("problem-21-11315-pre.txt", (21, 11315, 36455)),
            ("problem-3-7-pre.txt", (3, 7, 19)),
        ],
    )
    def test_real_files(self, shared_data, tmp_path, name, counts):
        path = shared_data / "bal" / name
        problem = read_bal(path)
        assert (problem.num_cameras, problem.num_points, problem.num_observations) == counts
        numbers = np.array(path.read_text().split()[3:], dtype=np.float64)
        observations = numbers[: 4 * counts[2]].reshape(-1, 4)
        np.testing.assert_array_equal(problem.camera_index, observations[:, 0])
        np.testing.assert_array_equal(problem.observations, observations[:, 2:])
        parameters = np.concatenate([problem.cameras.ravel(), problem.points.ravel()])
        np.testing.assert_array_equal(parameters, numbers[4 * counts[2] :])
        write_bal(problem, tmp_path / "copy.txt")
        assert read_bal(tmp_path / "copy.txt") == problem


class TestCompressed:
    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    def test_by_content(self, tmp_path, compress):
        path = tmp_path / "misnamed.txt"
        path.write_bytes(compress(VALID.encode()))
        assert read_bal(path) == read_bal(io.BytesIO(VALID.encode()))
        assert read_bal(io.BytesIO(path.read_bytes())) == read_bal(path)

    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    def test_several_members(self, compress):
        text = VALID.encode()
        data = compress(text[:50]) + compress(b"") + compress(text[50:])
        assert read_bal(io.BytesIO(data)) == read_bal(io.BytesIO(text))

    def test_zero_padding_is_ignored(self):
        data = gzip.compress(VALID.encode()) + b"\0" * 1000
        assert read_bal(io.BytesIO(data)).num_cameras == 2

    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    def test_every_truncation_is_refused(self, compress):
        data = compress(VALID.encode())
        for size in range(4, len(data)):
            assert "truncated" in error_of(data[:size]).reason

    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    def test_corrupt_bytes_are_refused(self, compress):
        data = bytearray(compress(VALID.encode() * 1))
        middle = len(data) // 2
        data[middle] ^= 0xFF
        assert error_of(bytes(data)).line >= 0
        good = compress(VALID.encode())
        damaged_checksum = good[:-6] + bytes([good[-6] ^ 1]) + good[-5:]
        error = error_of(damaged_checksum)
        assert error.field in ("gzip stream", "bzip2 stream")
        assert "corrupt" in error.reason

    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    def test_garbage_after_the_stream_is_refused(self, compress):
        assert "corrupt" in error_of(compress(VALID.encode()) + b"garbage garbage").reason

    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    @pytest.mark.parametrize("filler", [b" ", b"\n", b"0 "], ids=["blanks", "lines", "zeros"])
    def test_bombs_are_refused(self, compress, filler):
        bomb = compress(b"2000000 2000000 20000000\n" + filler * (1 << 21))
        assert len(bomb) < 100_000
        assert re.search("bomb|longer than|take at least", error_of(bomb).reason)

    @pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
    def test_text_longer_than_its_counts_can_need(self, compress):
        # Poorly compressible blanks, so that only the rule of counts can catch it.
        rng = np.random.default_rng(0)
        blanks = bytes(rng.choice(np.frombuffer(b" \t\n\r\v\f", np.uint8), 400_000))
        assert "longer than" in error_of(compress(VALID.encode() + blanks)).reason


class TestMalformed:
    @pytest.mark.parametrize(
        ("data", "line", "field", "reason"),
        [
            pytest.param(b"", 0, "", "is empty", id="empty"),
            pytest.param(b"  \n \n", 3, "number of cameras", "text ends", id="blank"),
            pytest.param(b"\x89PNG\r\n\x1a\n\0", 1, "number of cameras", r"\\x89PNG", id="binary"),
            pytest.param(b"\0" * 100, 1, "number of cameras", r"\\x00", id="NUL"),
            pytest.param(line_replaced(2, "0 0 1.0\0 2"), 2, "u of observation 0", "x00",
                         id="NUL inside"),
            pytest.param(b"\xef\xbb\xbf" + VALID.encode(), 1, "", "byte-order mark", id="BOM"),
            pytest.param(VALID.encode("utf-16"), 1, "number of cameras", "xff", id="UTF-16"),
            pytest.param(b"2\n", 2, "number of points", "text ends", id="short header"),
            pytest.param(b"2 3", 1, "number of observations", "text ends", id="two counts"),
            pytest.param(line_replaced(1, "two 3 4"), 1, "number of cameras", "'two'", id="word"),
            pytest.param(line_replaced(1, "2 3.0 4"), 1, "number of points", "'3.0'", id="real"),
            pytest.param(line_replaced(1, "2 3 4x"), 1, "number of obs", "'4x'", id="suffix"),
            pytest.param(line_replaced(1, "-2 3 4"), 1, "number of cameras", "'-2'", id="negative"),
            pytest.param(line_replaced(1, "0 3 4"), 1, "number of cameras", "'0'", id="no camera"),
            pytest.param(line_replaced(1, "2 0 4"), 1, "number of points", "'0'", id="no point"),
            pytest.param(line_replaced(1, "2 3 0"), 1, "number of obs", "'0'", id="no observation"),
            pytest.param(line_replaced(1, "2147483648 3 4"), 1, "number of cameras",
                         "2147483647", id="2^31"),
            pytest.param(line_replaced(1, "2 3 999999999999999999"), 1, "number of obs",
                         "'9{18}'", id="1e18 as digits"),
            pytest.param(line_replaced(1, "2 3 " + "9" * 30), 1, "number of obs", "9999",
                         id="beyond 64 bits"),
            pytest.param(line_replaced(1, "2 3 1e18"), 1, "number of obs", "'1e18'", id="1e18"),
            pytest.param(line_replaced(1, "2147483647 2147483647 2147483647"), 1, "header",
                         "take at least 68719476703 bytes", id="more than fits"),
            pytest.param(line_replaced(1, "2 3 100"), 1, "header", "take at least 853", id="100"),
            pytest.param(line_replaced(3, "-1 0 3 4"), 3, "camera index of observation 1",
                         "between 0 and 1 .*'-1'", id="camera negative"),
            pytest.param(line_replaced(3, "2 0 3 4"), 3, "camera index of observation 1",
                         "declares 2 cameras.*'2'", id="camera too large"),
            pytest.param(line_replaced(3, "1.0 0 3 4"), 3, "camera index of observation 1",
                         "expected an integer, got '1.0'", id="camera real"),
            pytest.param(line_replaced(5, "1 3 7 8"), 5, "point index of observation 3",
                         "declares 3 points.*'3'", id="point too large"),
            pytest.param(line_replaced(5, "1 -7 7 8"), 5, "point index of observation 3", "'-7'",
                         id="point negative"),
            pytest.param(line_replaced(5, "1 1.5 7 8"), 5, "point index of observation 3", "'1.5'",
                         id="point real"),
            pytest.param(line_replaced(5, "1 99999999999999999999 7 8"), 5,
                         "point index of observation 3", "between 0 and 2", id="point > 64 bits"),
            pytest.param(line_replaced(4, "0 1 5,25 -6"), 4, "u of observation 2", "'5,25'",
                         id="comma"),
            pytest.param(line_replaced(4, "0 1 5.25 0x1p3"), 4, "v of observation 2", "'0x1p3'",
                         id="hex"),
            pytest.param(line_replaced(4, "0 1 5.25 nan"), 4, "v of observation 2",
                         "must be finite, got 'nan'", id="nan"),
            pytest.param(line_replaced(4, "0 1 -inf 0"), 4, "u of observation 2", "'-inf'",
                         id="inf"),
            pytest.param(line_replaced(4, "0 1 1e999 0"), 4, "u of observation 2",
                         "too large for a double: '1e999'", id="1e999"),
            pytest.param(line_replaced(4, "0 1 1..5 0"), 4, "u of observation 2", "'1..5'",
                         id="two points"),
            pytest.param(line_replaced(4, "0 1 +-5 0"), 4, "u of observation 2", r"'\+-5'",
                         id="two signs"),
            pytest.param(line_replaced(4, "0 1 1d5 0"), 4, "u of observation 2", "'1d5'",
                         id="Fortran exponent"),
            pytest.param(line_replaced(4, "0 1 1e 0"), 4, "u of observation 2", "'1e'",
                         id="empty exponent"),
            pytest.param(line_replaced(4, "0 1 " + "1" * 2000 + " 0"), 4, "u of observation 2",
                         "'1{40}…'", id="endless number"),
            pytest.param(line_replaced(12, "NaN"), 12, "focal length of camera 0", "'NaN'",
                         id="camera nan"),
            pytest.param(line_replaced(14, "infinity"), 14, "k2 of camera 0", "'infinity'",
                         id="camera inf"),
            pytest.param(line_replaced(15, "-1e999"), 15, "rotation x of camera 1", "'-1e999'",
                         id="camera 1e999"),
            pytest.param(line_replaced(32, "nan(0)"), 32, "z of point 2", "finite", id="point nan"),
            pytest.param(line_replaced(31, "1" + "0" * 400), 31, "y of point 2", "too large",
                         id="point overflow"),
            pytest.param(VALID.encode() + b"12\n", 33, "end of file", "'12'", id="trailing number"),
            pytest.param(VALID.encode() + b"\0", 33, "end of file", "x00", id="trailing NUL"),
            pytest.param(lines_kept(3) + b" " * 60, 4, "camera index of observation 2",
                         "text ends here; the header declares 4 observations",
                         id="truncated in observations"),
            pytest.param(lines_kept(16) + b" " * 60, 17, "rotation z of camera 1",
                         "declares 2 cameras", id="truncated in cameras"),
            pytest.param(lines_kept(28) + b" " * 60, 29, "z of point 1", "declares 3 points",
                         id="truncated in points"),
        ],
    )  # fmt: skip
    def test_is_named(self, data, line, field, reason):
        error = error_of(data)
        assert error.line == line
        assert field in error.field
        assert re.search(reason, error.reason), error.reason
        place = f"<stream>:{line}" if line else "<stream>"
        assert str(error).startswith(place + ": ")

    def test_every_truncation_is_refused(self):
        text = VALID.rstrip().encode()
        for size in range(1, len(text)):
            error_of(text[:size])  # the last number has one digit: no cut leaves a whole problem

    def test_missing_file(self, tmp_path):
        path = tmp_path / "missing.txt"
        with pytest.raises(raylign.FormatError, match="cannot be opened: No such file") as caught:
            read_bal(path)
        assert caught.value.file == str(path)
        assert caught.value.line == 0

    def test_directory(self, tmp_path):
        with pytest.raises(raylign.FormatError, match="is a directory"):
            read_bal(tmp_path)

    def test_unreadable_file(self, tmp_path):
        path = tmp_path / "secret.txt"
        path.write_text(VALID)
        path.chmod(0)
        if os.access(path, os.R_OK):
            pytest.skip("this user may read everything")
        with pytest.raises(raylign.FormatError, match="Permission denied"):
            read_bal(path)

    def test_huge_counts_allocate_nothing(self):
        header = b"2147483647 2147483647 2147483647\n"
        limit = resource.getrlimit(resource.RLIMIT_AS)
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + (64 << 20), limit[1]))
        try:
            for data in [header, gzip.compress(header), bz2.compress(header)]:
                assert "take at least" in error_of(data).reason
        finally:
            resource.setrlimit(resource.RLIMIT_AS, limit)

    def test_negative_focal_length_is_data(self):
        problem = read_bal(io.BytesIO(line_replaced(12, "-500")))
        assert problem.statistics().num_non_positive_focal == 1


class TestDuplicates:
    DATA = line_replaced(5, "0 0 10.5 20.5")  # repeats observation 0 on line 2: -1.5 2.5

    def test_error_by_default(self):
        error = error_of(self.DATA)
        assert (error.line, error.field) == (5, "observation 3")
        assert "camera 0, point 0 of observation 0 on line 2" in error.reason

    def test_line_when_observations_share_lines(self):
        data = b"1 1 3\n0 0 1 2 0 0 3 4\n\n\n0\n0 5 6\n" + b"0 " * 12
        assert error_of(data).line == 2
        data = b"1 2 3\n0 0 1 2 0 1 3 4\n\n\n0\n0 5 6\n" + b"0 " * 15
        assert error_of(data).line == 5

    @pytest.mark.parametrize(
        ("policy", "pixels"),
        [("first", [-1.5, 2.5]), ("mean", [4.5, 11.5])],
    )
    def test_merged(self, policy, pixels):
        problem = read_bal(io.BytesIO(self.DATA), duplicates=policy)
        assert problem.num_observations == 3
        np.testing.assert_array_equal(problem.observations[0], pixels)
        np.testing.assert_array_equal(problem.observations[1:], [[3, 40], [5.25, -6]])
        np.testing.assert_array_equal(problem.camera_index, [0, 1, 0])
        assert problem.statistics().num_duplicate_observations == 0

    def test_mean_of_many(self):
        data = b"1 1 4\n" + b"0 0 1 10\n0 0 2 20\n0 0 3 30\n0 0 6 60\n" + b"0 " * 12
        problem = read_bal(io.BytesIO(data), duplicates="mean")
        np.testing.assert_allclose(problem.observations, [[3.0, 30.0]], rtol=1e-15)

    def test_kept(self):
        problem = read_bal(io.BytesIO(self.DATA), duplicates="keep")
        assert problem.num_observations == 4
        assert problem.statistics().num_duplicate_observations == 1

    def test_unknown_policy(self):
        with pytest.raises(raylign.OptionsError, match="'last'"):
            read_bal(io.BytesIO(VALID.encode()), duplicates="last")


class TestSources:
    @pytest.mark.parametrize("source", [None, 3, [VALID], b"path", bytearray(b"x")])
    def test_wrong_type(self, source):
        with pytest.raises(TypeError, match="path or a binary file object"):
            read_bal(source)

    def test_text_mode_is_refused(self, tmp_path):
        path = tmp_path / "problem.txt"
        path.write_text(VALID)
        with path.open() as stream, pytest.raises(TypeError, match="text mode"):
            read_bal(stream)
        with pytest.raises(TypeError, match="text mode"):
            write_bal(make_tiny_problem(), io.StringIO())

    def test_null_character_in_path(self):
        with pytest.raises(ValueError, match="null"):
            read_bal("problem\0.txt")

    def test_binary_file_keeps_its_name_in_messages(self, tmp_path):
        path = tmp_path / "broken.txt"
        path.write_bytes(b"1 2 x")
        with path.open("rb") as stream, pytest.raises(raylign.FormatError) as caught:
            read_bal(stream)
        assert caught.value.file == str(path)


class TestWrite:
    def test_extreme_numbers_survive(self, tmp_path):
        problem = make_tiny_problem()
        problem.points.flat[:6] = [-0.0, 5e-324, -sys.float_info.max, 0.1, 1 / 3, 1e23]
        rng = np.random.default_rng(2)
        bits = rng.integers(0, 2**64, (80, 2), dtype=np.uint64, endpoint=False)
        values = bits.view(np.float64)
        problem.observations[:] = np.where(np.isfinite(values), values, 1.0)
        for name in ["a.txt", "a.txt.gz", "a.txt.bz2"]:
            write_bal(problem, tmp_path / name)
            assert read_bal(tmp_path / name) == problem

    def test_file_object(self):
        stream = io.BytesIO()
        write_bal(make_tiny_problem(), stream)
        stream.seek(0)
        assert read_bal(stream) == make_tiny_problem()

    def test_format(self):
        stream = io.BytesIO()
        write_bal(read_bal(io.BytesIO(VALID.encode())), stream)
        lines = stream.getvalue().decode().splitlines()
        assert lines[:3] == ["2 3 4", "0 0     -1.5 2.5", "1 0     3 40"]
        assert len(lines) == 1 + 4 + 2 * 9 + 3 * 3
        assert lines[22] == "-0"

    def test_suffix_compresses_reproducibly(self, tmp_path):
        for suffix, decompress in [(".gz", gzip.decompress), (".bz2", bz2.decompress)]:
            path = tmp_path / f"problem.txt{suffix}"
            write_bal(make_tiny_problem(), path)
            first = path.read_bytes()
            write_bal(make_tiny_problem(), path)
            assert path.read_bytes() == first
            plain = io.BytesIO()
            write_bal(make_tiny_problem(), plain)
            assert decompress(first) == plain.getvalue()

    @pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize("name", ["cameras", "points", "observations"])
    def test_failure_leaves_the_old_file(self, tmp_path, name, value):
        path = tmp_path / "problem.txt"
        path.write_text("old")
        problem = make_tiny_problem()
        getattr(problem, name)[-1, -1] = value
        with pytest.raises(raylign.FormatError, match="not finite") as caught:
            write_bal(problem, path)
        assert caught.value.field == f"{name[:-1]} {len(getattr(problem, name)) - 1}"
        assert path.read_text() == "old"
        assert list(tmp_path.iterdir()) == [path]

    def test_full_disk_leaves_the_old_file(self, tmp_path):
        path = tmp_path / "problem.txt"
        path.write_text("old")
        script = textwrap.dedent("""
            import resource, signal, sys, raylign
            from tiny_problem import make_tiny_problem
            from raylign.io import write_bal
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
            try:
                write_bal(make_tiny_problem(), sys.argv[1])
            except raylign.FormatError as error:
                assert "cannot be written: File too large" in str(error), error
            else:
                sys.exit("not refused")
        """)
        here = Path(__file__).parent
        subprocess.run([sys.executable, "-c", script, str(path)], cwd=here, check=True)
        assert path.read_text() == "old"
        assert list(tmp_path.iterdir()) == [path]

    @pytest.mark.parametrize("counts", [(0, 3, 4), (2, 0, 4), (2, 3, 0)])
    def test_empty_problem_is_refused(self, tmp_path, counts):
        cameras, points, observations = counts
        used = min(cameras, points) and observations
        problem = raylign.scene.BalProblem(
            np.zeros((cameras, 9)),
            np.zeros((points, 3)),
            np.zeros(used, np.int32),
            np.zeros(used, np.int32),
            np.zeros((used, 2)),
        )
        with pytest.raises(raylign.FormatError, match="1 to 2147483647"):
            write_bal(problem, tmp_path / "problem.txt")
        assert list(tmp_path.iterdir()) == []

    def test_broken_problem_is_refused(self, tmp_path):
        problem = make_tiny_problem()
        problem.camera_index[0] = -1
        with pytest.raises(raylign.ShapeError):
            write_bal(problem, tmp_path / "problem.txt")

    def test_unwritable_targets(self, tmp_path):
        with pytest.raises(raylign.FormatError, match="cannot be written: is a directory"):
            write_bal(make_tiny_problem(), tmp_path)
        with pytest.raises(raylign.FormatError, match="cannot be written: No such file"):
            write_bal(make_tiny_problem(), tmp_path / "missing" / "problem.txt")

    def test_permissions_and_links_are_respected(self, tmp_path, umask):
        fresh = tmp_path / "fresh.txt"
        write_bal(make_tiny_problem(), fresh)
        assert fresh.stat().st_mode & 0o777 == 0o666 & ~umask
        fresh.chmod(0o640)
        link = tmp_path / "link.txt"
        link.symlink_to(fresh)
        write_bal(make_tiny_problem(seed=8), link)
        assert link.is_symlink()
        assert fresh.stat().st_mode & 0o777 == 0o640
        assert read_bal(fresh) == make_tiny_problem(seed=8)

    def test_device(self):
        write_bal(make_tiny_problem(), "/dev/null")
        assert Path("/dev/null").is_char_device()


def test_locale_does_not_matter(tmp_path):
    for name in ["de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8"]:
        with contextlib.suppress(locale.Error):
            before = locale.setlocale(locale.LC_ALL)
            locale.setlocale(locale.LC_ALL, name)
            break
    else:
        pytest.skip("no locale with decimal commas installed")
    try:
        assert locale.localeconv()["decimal_point"] == ","
        write_bal(make_tiny_problem(), tmp_path / "problem.txt")
        assert read_bal(tmp_path / "problem.txt") == make_tiny_problem()
        assert b"," not in (tmp_path / "problem.txt").read_bytes()
    finally:
        locale.setlocale(locale.LC_ALL, before)
