"""Synthetic BAL problems: façade, streaming writer, shipped data.

The properties of the scenes are tested in tests/cpp/synthetic.
"""

import gzip
import hashlib
import pickle
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign import io, synthetic
from raylign.synthetic import BalKind, BalOptions

DATA = Path(__file__).resolve().parents[2] / "data"
KINDS = [BalKind.STREET, BalKind.ORBIT]


def project(problem):
    """Pixels of all observations, from the definition: Rodrigues' formula and P_xy / −P_z."""
    cameras = problem.cameras[problem.camera_index]
    points = problem.points[problem.point_index]
    omega, t_cw = cameras[:, :3], cameras[:, 3:6]
    angle = np.linalg.norm(omega, axis=1, keepdims=True)
    axis = omega / angle
    cos, sin = np.cos(angle), np.sin(angle)
    dot = np.sum(axis * points, axis=1, keepdims=True)
    p_c = cos * points + sin * np.cross(axis, points) + (1 - cos) * dot * axis + t_cw
    p = -p_c[:, :2] / p_c[:, 2:]
    r2 = np.sum(p * p, axis=1)
    scale = cameras[:, 6] * (1 + cameras[:, 7] * r2 + cameras[:, 8] * r2**2)
    return scale[:, None] * p, -p_c[:, 2]


@pytest.mark.parametrize("kind", KINDS)
def test_zero_noise_truth_has_zero_residual_by_an_independent_projection(kind):
    scene = synthetic.bal(kind=kind, num_cameras=40, num_points=2000, pixel_noise=0.0)
    predicted, depth = project(scene.truth)
    assert np.abs(predicted - scene.truth.observations).max() <= 1e-9
    assert depth.min() > 0.0
    assert scene.inlier_mask.all()


@pytest.mark.parametrize("kind", KINDS)
def test_result_has_the_promised_arrays(kind):
    options = BalOptions(kind=kind, num_cameras=30, num_points=500, outlier_fraction=0.1, seed=3)
    scene = synthetic.bal(options)
    count = scene.problem.num_observations
    assert scene.options == options
    assert scene.inlier_mask.shape == (count,)
    assert scene.inlier_mask.dtype == np.bool_
    assert scene.problem.colors.shape == (500, 3)
    assert scene.problem.colors.dtype == np.uint8
    assert len(np.unique(scene.problem.colors, axis=0)) > 50
    assert np.array_equal(scene.problem.observations, scene.truth.observations)
    assert np.array_equal(scene.problem.point_index, scene.truth.point_index)
    outliers = np.linalg.norm(project(scene.truth)[0] - scene.truth.observations, axis=1) > 5.0
    assert np.mean(outliers == ~scene.inlier_mask) > 0.99


def test_keywords_override_options_and_kind_may_be_a_name():
    base = BalOptions(num_cameras=12, num_points=200)
    scene = synthetic.bal(base, kind="orbit", seed=9)
    assert scene.options == base.replace(kind=BalKind.ORBIT, seed=9)
    assert base.kind is BalKind.STREET
    with pytest.raises(raylign.OptionsError, match=r"kind must be one of street, orbit"):
        synthetic.bal(kind="spiral")
    with pytest.raises(TypeError, match="no option 'cameras'"):
        synthetic.bal(cameras=3)
    with pytest.raises(raylign.OptionsError, match=r"BalOptions\.num_points must be >= 48"):
        synthetic.bal(base, num_points=10)


def test_options_survive_pickle_and_repr():
    options = BalOptions(kind=BalKind.ORBIT, seed=2**64 - 1, pixel_noise=0.25)
    assert pickle.loads(pickle.dumps(options)) == options
    assert eval(repr(options), {"BalOptions": BalOptions, "BalKind": BalKind}) == options


def test_perturbation_has_its_size():
    options = BalOptions(num_cameras=200, num_points=4000, translation_noise=0.0, point_noise=0.0)
    scene = synthetic.bal(options, rotation_noise_deg=1.0, focal_noise=0.02)
    relative = scene.problem.cameras[:, 6] / scene.truth.cameras[:, 6] - 1.0
    assert np.std(relative) == pytest.approx(0.02, rel=0.3)
    assert np.array_equal(scene.problem.points, scene.truth.points)

    def centers_and_rotations(cameras):
        angle = np.linalg.norm(cameras[:, :3], axis=1)[:, None, None]
        x, y, z = (cameras[:, :3] / angle[:, :, 0]).T
        zero = np.zeros_like(x)
        hat = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
        R_cw = np.eye(3) + np.sin(angle) * hat + (1 - np.cos(angle)) * hat @ hat
        return -np.einsum("nji,nj->ni", R_cw, cameras[:, 3:6]), R_cw

    start, R_start = centers_and_rotations(scene.problem.cameras)
    true, R_true = centers_and_rotations(scene.truth.cameras)
    assert np.abs(start - true).max() < 1e-9  # turned about its centre
    traces = np.einsum("nij,nij->n", R_start, R_true)
    angles = np.degrees(np.arccos(np.clip((traces - 1) / 2, -1, 1)))
    assert np.sqrt(np.mean(angles**2)) == pytest.approx(np.sqrt(3.0), rel=0.2)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("suffix", [".txt", ".txt.gz", ".txt.bz2"])
def test_streamed_file_equals_the_problem_in_memory(tmp_path, kind, suffix):
    options = BalOptions(kind=kind, num_cameras=20, num_points=500, outlier_fraction=0.05)
    path, truth_path = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    seen = []
    counts = synthetic.write_bal(
        path,
        options=options,
        truth_path=truth_path,
        progress=lambda done, total: seen.append((done, total)),
    )
    scene = synthetic.bal(options)
    assert counts == (20, 500, scene.problem.num_observations)
    assert seen[-1] == (counts[2], counts[2])
    for read, made in ((io.read_bal(path), scene.problem), (io.read_bal(truth_path), scene.truth)):
        for name in ("cameras", "points", "observations", "camera_index", "point_index"):
            assert np.array_equal(getattr(read, name), getattr(made, name)), name
    again = tmp_path / f"c{suffix}"
    synthetic.write_bal(again, options=options)
    assert again.read_bytes() == path.read_bytes()


def test_a_stopped_or_failed_writer_leaves_nothing(tmp_path):
    options = BalOptions(num_cameras=10, num_points=9000)
    with pytest.raises(raylign.Error, match="stopped by the progress callback"):
        synthetic.write_bal(tmp_path / "a.txt", options=options, progress=lambda *_: False)
    with pytest.raises(ZeroDivisionError):
        synthetic.write_bal(tmp_path / "a.txt", options=options, progress=lambda *_: 1 / 0)
    with pytest.raises(raylign.OptionsError, match="same file"):
        synthetic.write_bal(tmp_path / "a", options=options, truth_path=tmp_path / "a")
    with pytest.raises(raylign.FormatError):
        synthetic.write_bal(tmp_path / "absent" / "a.txt", options=options)
    assert list(tmp_path.iterdir()) == []


MEMORY_SCRIPT = """
import resource, sys
from raylign.synthetic import BalOptions, write_bal
options = BalOptions(num_cameras=1778, num_points=1_000_000, num_observations=5_000_000)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
counts = write_bal(sys.argv[1], options=options)
print(*counts, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.slow
def test_five_million_observations_in_bounded_memory(tmp_path):
    command = [sys.executable, "-c", MEMORY_SCRIPT, str(tmp_path / "big.txt")]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    *counts, grown_kib = map(int, output.split())
    assert counts == [1778, 1_000_000, 5_000_000]
    assert grown_kib < 50 * 1024  # the problem itself would need 200 MB


def shipped_commands():
    """The commands of scripts/make_data.sh, as (file, truth file, options)."""
    script = (DATA.parent / "scripts" / "make_data.sh").read_text().replace("\\\n", " ")
    for line in script.splitlines():
        if not line.startswith("raylign synthetic bal"):
            continue
        words = [word for word in shlex.split(line)[3:] if word != "-q"]
        values = dict(zip(words[::2], words[1::2], strict=True))
        output, truth = values.pop("-o"), values.pop("--truth")
        options = BalOptions()
        for key, text in values.items():
            name = key.removeprefix("--").replace("-", "_")
            default = getattr(options, name)
            value = BalKind[text.upper()] if name == "kind" else type(default)(text)
            options = options.replace(**{name: value})
        yield pytest.param(output, truth, options, id=output)


@pytest.mark.parametrize(("output", "truth", "options"), list(shipped_commands()))
def test_shipped_files_are_made_by_the_printed_commands(tmp_path, output, truth, options):
    synthetic.write_bal(tmp_path / "p.txt", options=options, truth_path=tmp_path / "t.txt")
    for made, shipped in (("p.txt", output), ("t.txt", truth)):
        raw = (DATA / "bal" / shipped).read_bytes()
        text = gzip.decompress(raw) if shipped.endswith(".gz") else raw
        assert (tmp_path / made).read_bytes() == text, shipped
        if shipped.endswith(".gz"):
            assert raw[4:8] == b"\0\0\0\0", "gzip time stamp"


def test_data_readme_is_right():
    readme = (DATA / "README.md").read_text()
    rows = re.findall(r"^\| `(\S+)` \| (\d+) \| (\d+) \| (\d+) \| `(\w+)` \|$", readme, re.M)
    assert {row[0] for row in rows} == {path.name for path in (DATA / "bal").iterdir()}
    for name, cameras, points, observations, digest in rows:
        raw = (DATA / "bal" / name).read_bytes()
        text = gzip.decompress(raw) if name.endswith(".gz") else raw
        assert hashlib.sha256(text).hexdigest() == digest, name
        assert text.split(b"\n", 1)[0] == f"{cameras} {points} {observations}".encode(), name
    script = (DATA.parent / "scripts" / "make_data.sh").read_text()
    for command in re.findall(r"^raylign .*(?:\\\n.*)*", script, re.M):
        assert command in readme
    assert sum(path.stat().st_size for path in (DATA / "bal").iterdir()) < 2_000_000
