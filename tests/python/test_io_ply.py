import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import raylign
from raylign.io import PlySummary, write_ply, write_ply_points
from tiny_problem import make_tiny_problem

VERTEX = np.dtype([("xyz", "<f4", 3), ("rgb", "u1", 3)])
FACE = np.dtype([("count", "u1"), ("vertices", "<i4", 3)])


def parse(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a PLY file, read by NumPy alone; checks every byte is accounted for."""
    head, _, body = data.partition(b"end_header\n")
    lines = [line for line in head.decode("ascii").splitlines() if not line.startswith("comment")]
    num_vertices = int(re.fullmatch(r"element vertex (\d+)", lines[2])[1])
    num_faces = int(re.fullmatch(r"element face (\d+)", lines[9])[1])
    assert lines == [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {num_vertices}",
        *[f"property float {axis}" for axis in "xyz"],
        *[f"property uchar {name}" for name in ["red", "green", "blue"]],
        f"element face {num_faces}",
        "property list uchar int vertex_indices",
    ]
    size = num_vertices * VERTEX.itemsize
    assert len(body) == size + num_faces * FACE.itemsize
    vertices = np.frombuffer(body[:size], VERTEX)
    faces = np.frombuffer(body[size:], FACE)
    assert np.isfinite(vertices["xyz"]).all()
    assert (faces["count"] == 3).all()
    if num_faces:
        assert faces["vertices"].min() >= 0
        assert faces["vertices"].max() < num_vertices
    return vertices, faces["vertices"]


def test_points(tmp_path):
    problem = make_tiny_problem()
    summary = write_ply(problem, tmp_path / "scene.ply", cameras=False, point_color=(1, 2, 3))
    assert summary == PlySummary(20, 0, 0, 0)
    vertices, faces = parse((tmp_path / "scene.ply").read_bytes())
    np.testing.assert_array_equal(vertices["xyz"], problem.points.astype(np.float32))
    np.testing.assert_array_equal(vertices["rgb"], [[1, 2, 3]] * 20)
    assert len(faces) == 0


def test_frusta_stand_where_the_cameras_are_and_open_along_minus_z(tmp_path):
    problem = make_tiny_problem()
    problem.cameras[:, :3] += [[0.1, 0.2, 0.3]]
    depth = 0.25
    summary = write_ply(problem, tmp_path / "scene.ply", camera_scale=depth, camera_color=(9, 8, 7))
    assert summary == PlySummary(20, 4, 0, 0)
    vertices, faces = parse((tmp_path / "scene.ply").read_bytes())
    frusta = vertices["xyz"][20:].reshape(4, 6, 3)
    assert (vertices["rgb"][20:] == [9, 8, 7]).all()
    R_cw = Rotation.from_rotvec(problem.cameras[:, :3]).as_matrix()
    t_cw = problem.cameras[:, 3:6]
    p_c = np.einsum("cij,ckj->cki", R_cw, frusta) + t_cw[:, None]
    np.testing.assert_allclose(p_c[:, 0], 0.0, atol=1e-5)  # float32 of coordinates near 6
    np.testing.assert_allclose(p_c[:, 1:, 2], -depth, atol=1e-5)
    # The widest observation lies on the border of the drawn image.
    for c in range(4):
        seen = np.abs(problem.observations[problem.camera_index == c]).max(axis=0)
        half = seen / problem.cameras[c, 6] * depth
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        np.testing.assert_allclose(p_c[c, 1:5, :2], corners, atol=1e-5)
        np.testing.assert_allclose(p_c[c, 5, :2], [0.0, 1.4 * half[1]], atol=1e-5)
    assert len(faces) == 4 * 7
    np.testing.assert_array_equal(faces[7:14] - faces[:7], 6)
    assert set(faces[:7].ravel()) == set(range(20, 26))


def test_faces_close_the_frustum_and_look_outwards(tmp_path):
    write_ply(make_tiny_problem(), tmp_path / "scene.ply", camera_scale=1.0)
    vertices, faces = parse((tmp_path / "scene.ply").read_bytes())
    closed = faces[:6]  # without the tip
    edges = {(a, b) for face in closed for a, b in zip(face, np.roll(face, -1), strict=True)}
    assert len(edges) == 18
    assert all((b, a) in edges for a, b in edges)
    xyz = vertices["xyz"].astype(float)
    volume = sum(np.linalg.det(xyz[face] - xyz[20:25].mean(axis=0)) for face in closed) / 6.0
    assert volume > 0.0


def test_default_scale_follows_the_scene(tmp_path):
    depths = []
    for factor in [1.0, 1000.0]:
        problem = make_tiny_problem().transformed(np.diag([factor, factor, factor, 1.0]))
        write_ply(problem, tmp_path / "scene.ply")
        xyz = parse((tmp_path / "scene.ply").read_bytes())[0]["xyz"][20:26].astype(float)
        depths.append(np.linalg.norm(xyz[1:5].mean(axis=0) - xyz[0]))
    assert depths[1] / depths[0] == pytest.approx(1000.0, rel=1e-3)


def test_colors(tmp_path):
    path = tmp_path / "scene.ply"
    given = np.linspace(-100, 400, 60).reshape(20, 3)
    write_ply(make_tiny_problem(), path, colors=given)
    vertices, _ = parse(path.read_bytes())
    np.testing.assert_array_equal(vertices["rgb"][:20], np.clip(np.rint(given), 0, 255))
    own = np.arange(60, dtype=np.uint8).reshape(20, 3)
    write_ply(make_tiny_problem().replace(colors=own), path, camera_color=(300, -5, 0.6))
    vertices, _ = parse(path.read_bytes())
    np.testing.assert_array_equal(vertices["rgb"][:20], own)
    np.testing.assert_array_equal(vertices["rgb"][20], [255, 0, 1])


def test_only_finite_numbers_are_written(tmp_path):
    problem = make_tiny_problem().replace(colors=np.arange(60, dtype=np.uint8).reshape(20, 3))
    problem.points[3] = np.nan
    problem.points[5, 1] = np.inf
    problem.points[7, 2] = 1e300  # too large for a 32-bit float
    problem.cameras[1, 4] = np.nan
    problem.cameras[2, 6:] = np.nan  # intrinsics only shape the drawing
    problem.observations[0] = np.nan
    summary = write_ply(problem, tmp_path / "scene.ply")
    assert summary == PlySummary(17, 3, 2, 1, 1)
    vertices, faces = parse((tmp_path / "scene.ply").read_bytes())
    assert len(vertices) == 17 + 3 * 6
    assert len(faces) == 3 * 7
    kept = np.delete(np.arange(20), [3, 5, 7])
    np.testing.assert_array_equal(vertices["rgb"][:17], problem.colors[kept])


def test_empty_problem(tmp_path):
    problem = raylign.scene.BalProblem(
        np.empty((0, 9)),
        np.empty((0, 3)),
        np.empty(0, np.int32),
        np.empty(0, np.int32),
        np.empty((0, 2)),
    )
    assert write_ply(problem, tmp_path / "scene.ply") == PlySummary(0, 0, 0, 0)
    assert len(parse((tmp_path / "scene.ply").read_bytes())[0]) == 0


def test_compressed_by_suffix(tmp_path):
    write_ply(make_tiny_problem(), tmp_path / "scene.ply")
    write_ply(make_tiny_problem(), tmp_path / "scene.ply.gz")
    plain = (tmp_path / "scene.ply").read_bytes()
    assert gzip.decompress((tmp_path / "scene.ply.gz").read_bytes()) == plain


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_impossible_scale(tmp_path, scale):
    with pytest.raises(raylign.OptionsError, match="camera_scale"):
        write_ply(make_tiny_problem(), tmp_path / "scene.ply", camera_scale=scale)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"colors": np.zeros((19, 3))}, raylign.ShapeError),
        ({"colors": np.zeros((20, 3), complex)}, raylign.ShapeError),
        ({"colors": np.full((20, 3), np.nan)}, raylign.OptionsError),
        ({"camera_color": (1, 2)}, raylign.ShapeError),
        ({"point_color": "red"}, raylign.ShapeError),
    ],
)
def test_impossible_colors(tmp_path, options, error):
    with pytest.raises(error):
        write_ply(make_tiny_problem(), tmp_path / "scene.ply", **options)


def test_failure_leaves_the_old_file(tmp_path):
    path = tmp_path / "scene.ply"
    path.write_text("old")
    problem = make_tiny_problem()
    problem.point_index[0] = 99
    with pytest.raises(raylign.ShapeError):
        write_ply(problem, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(raylign.FormatError, match="cannot be written"):
        write_ply(make_tiny_problem(), tmp_path / "missing" / "scene.ply")


def test_far_points_are_left_out_and_counted(tmp_path):
    problem = make_tiny_problem()
    distances = np.abs(problem.points - np.median(problem.points, axis=0)).sum(axis=1)
    extent = np.median(distances)
    problem.points[4, 0] += 80.0 * extent
    problem.points[6, 1] -= 140.0 * extent
    path = tmp_path / "scene.ply"
    assert write_ply(problem, path, cameras=False) == PlySummary(19, 0, 0, 0, 1)
    vertices, _ = parse(path.read_bytes())
    kept = np.delete(problem.points, 6, axis=0).astype(np.float32)
    np.testing.assert_array_equal(vertices["xyz"], kept)
    assert write_ply(problem, path, max_distance=np.inf).num_points == 20
    assert write_ply(problem, path, max_distance=50.0 * extent).num_far_points == 2
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(raylign.OptionsError, match="max_distance"):
            write_ply(problem, path, max_distance=bad)


def test_points_in_one_place_are_all_written(tmp_path):
    problem = make_tiny_problem()
    problem.points[:] = 1.0
    problem.points[0] = 9.0
    assert write_ply(problem, tmp_path / "scene.ply").num_points == 20


def test_needs_a_path():
    with pytest.raises(TypeError):
        write_ply(make_tiny_problem(), 3)


@pytest.mark.data
def test_real_problem(shared_data: Path, tmp_path: Path):
    problem = raylign.io.read_bal(shared_data / "bal" / "problem-49-7776-pre.txt")
    assert write_ply(problem, tmp_path / "near.ply") == PlySummary(7752, 49, 0, 0, 24)
    path = tmp_path / "ladybug.ply"
    assert write_ply(problem, path, max_distance=np.inf) == PlySummary(7776, 49, 0, 0, 0)
    vertices, faces = parse((tmp_path / "ladybug.ply").read_bytes())
    np.testing.assert_allclose(
        vertices["xyz"][7776::6], problem.camera_centers(), rtol=1e-6, atol=1e-6
    )
    assert len(faces) == 49 * 7


def test_a_cloud_without_cameras(tmp_path):
    points = np.random.default_rng(0).normal(size=(5, 3)) * [1.0, 1.0, 1e6]
    points[3] = np.nan
    colors = np.arange(15).reshape(5, 3)
    summary = write_ply_points(points, tmp_path / "cloud.ply", colors=colors)
    assert summary == PlySummary(4, 0, 1, 0)
    vertices, faces = parse((tmp_path / "cloud.ply").read_bytes())
    kept = [0, 1, 2, 4]
    np.testing.assert_array_equal(vertices["xyz"], points[kept].astype(np.float32))
    np.testing.assert_array_equal(vertices["rgb"], colors[kept])
    assert len(faces) == 0
    with pytest.raises(raylign.ShapeError):
        write_ply_points(points[:, :2], tmp_path / "cloud.ply")
