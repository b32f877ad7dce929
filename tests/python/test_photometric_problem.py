"""Photometric problems: every form of input, what is refused, points chosen from depth."""

from pathlib import Path

import numpy as np
import pytest

import raylign
from raylign import geometry, image, io, photometric, synthetic
from raylign.camera import PinholeCamera, RadtanCamera
from sequence_trees import save_image

WIDTH, HEIGHT = 96, 72
CAMERA = PinholeCamera(80.0, 82.0, 47.0, 36.0)
T_CW = geometry.se3_exp([[0.05 * i, 0.0, 0.0, 0.0, 0.01 * i, 0.0] for i in range(3)])
POINTS = np.random.default_rng(3).uniform([-0.4, -0.3, 1.5], [0.4, 0.3, 2.5], (20, 3))


@pytest.fixture(scope="module")
def frames():
    scene = synthetic.room(seed=2)
    return [synthetic.render(scene, CAMERA, T, width=WIDTH, height=HEIGHT) for T in T_CW]


@pytest.fixture(scope="module")
def images(frames):
    return [frame.image for frame in frames]


def make(images, **changes):
    """A problem, with some arguments changed."""
    arguments = {"images": images, "K": CAMERA, "T_cw": T_CW, "points": POINTS, **changes}
    return photometric.Problem(**arguments)


@pytest.mark.parametrize(
    "K",
    [
        CAMERA,
        CAMERA.matrix(),
        CAMERA.params,
        [80, 82, 47, 36],
        [CAMERA] * 3,
        np.stack([CAMERA.matrix()] * 3),
        np.tile(CAMERA.params, (3, 1)),
    ],
)
def test_cameras_in_every_form(images, K):
    problem = make(images, K=K)
    assert problem.intrinsics.shape[0] in (1, 3)
    np.testing.assert_array_equal(problem.intrinsics[0], [80, 82, 47, 36])
    assert problem.camera(2) == CAMERA


def test_poses_in_every_form(images):
    q = geometry.quaternion_from_matrix(np.ascontiguousarray(T_CW[:, :3, :3]))
    rows = np.column_stack([T_CW[:, :3, 3], q])
    T_wc = geometry.se3_inverse(T_CW)
    q_wc = geometry.quaternion_from_matrix(np.ascontiguousarray(T_wc[:, :3, :3]))
    for T, convention in (
        (rows, "cw"),
        (T_wc, "wc"),
        (np.column_stack([T_wc[:, :3, 3], q_wc]), "wc"),
    ):
        problem = make(images, T_cw=T, convention=convention)
        np.testing.assert_allclose(problem.T_cw, T_CW, atol=1e-14)
    np.testing.assert_array_equal(make(images, T_cw=T_CW).T_cw, T_CW)  # bit by bit


def test_images_in_every_form(images, tmp_path: Path):
    for i, picture in enumerate(images):
        save_image(tmp_path / f"{i}.png", picture)
    wide = [picture.astype(np.uint16) * 257 for picture in images]
    floats = [picture.astype(np.float32) for picture in images]
    color = [np.repeat(picture[..., None], 3, axis=2) for picture in images]
    for given in (io.list_images(tmp_path), wide, floats, color, [images[0], *color[1:]]):
        problem = make(given)
        for i, picture in enumerate(images):
            np.testing.assert_allclose(problem.image(i), picture, atol=2e-5)
    assert problem.color_image(0) is None
    np.testing.assert_array_equal(problem.color_image(1), color[1])
    assert make([images[0], images[1][:50], images[2]]).image(1).shape == (50, WIDTH)


def test_rows_become_columns(images):
    patches = np.arange(20 * 16, dtype=np.float32).reshape(20, 16)
    by_column = make(images, patches=patches).patches
    by_row = make(images, patches=patches, patch_order="row").patches
    np.testing.assert_array_equal(by_column, patches)
    np.testing.assert_array_equal(by_row[0].reshape(4, 4), patches[0].reshape(4, 4).T)
    with pytest.raises(raylign.OptionsError, match="square patches, got 8"):
        make(images, patches=patches[:, :8], patch_order="row")


def test_patches_have_as_many_numbers_as_their_pattern(images):
    patches = np.zeros((20, 15))
    assert make(images, patches=patches).patch_size == 15  # a pattern of one's own
    with pytest.raises(raylign.ShapeError, match=r"patches .*16.*\(20, 15\)"):
        make(images, patches=patches, pattern=photometric.PatchPattern.parse("4x4"))
    custom = photometric.PatchPattern([(u, v) for u in range(5) for v in range(3)])
    assert make(images, patches=patches, pattern=custom).patch_size == 15
    with pytest.raises(raylign.ShapeError, match=r"patches .*16.*\(20, 15\)"):
        make(images, patches=patches, pattern="4x4")
    with pytest.raises(raylign.OptionsError):
        make(images, patches=patches, pattern="7q")


@pytest.mark.parametrize("width", [1e9, np.nan, np.inf])
def test_a_blur_without_bounds_is_refused(width):
    with pytest.raises(raylign.OptionsError, match=r"presmooth must be finite and <= 100"):
        photometric.PhotometricOptions(presmooth=width)


def bad_pose(row: int, value) -> np.ndarray:
    T = T_CW.copy()
    T[row, :3, :3] = value
    return T


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"images": []}, raylign.ShapeError, "empty"),
        ({"images": "folder"}, raylign.ShapeError, "list_images"),
        ({"images": [np.zeros((4, 4))] * 3}, raylign.ShapeError, r"images\[0\]"),
        ({"images": [7] * 3}, raylign.ShapeError, r"images\[0\].*int"),
        ({"images": ["none.png"] * 3}, raylign.FormatError, "none.png"),
        ({"T_cw": T_CW[:2]}, raylign.ShapeError, "3 images but 2 poses"),
        ({"T_cw": np.eye(4)}, raylign.ShapeError, r"T_cw .*\(4, 4\)"),
        ({"T_cw": np.ones((3, 7))}, raylign.ShapeError, r"T_cw\[0\]: the quaternion's norm is 2"),
        ({"T_cw": bad_pose(1, np.diag([1, 1, -1]))}, raylign.ShapeError, "1"),
        ({"T_cw": bad_pose(2, np.nan)}, raylign.ShapeError, "2"),
        ({"convention": "xy"}, raylign.OptionsError, "'cw' or 'wc', got 'xy'"),
        ({"points": POINTS[:, :2]}, raylign.ShapeError, r"points .*\(20, 2\)"),
        ({"points": np.where(np.arange(60).reshape(20, 3) == 5, np.nan, POINTS)},
         raylign.ShapeError, r"points.*1"),
        ({"K": np.ones((3, 3))}, raylign.OptionsError, r"fx 0 cx"),
        ({"K": [80, 82, 200, 36]}, raylign.OptionsError, r"96 x 72 px.*\(200, 36\)"),
        ({"K": [0, 82, 47, 36]}, raylign.OptionsError, "fx must be > 0"),
        ({"K": [CAMERA] * 2}, raylign.ShapeError, "2 cameras for 3 images"),
        ({"patches": np.zeros((19, 16))}, raylign.ShapeError, r"patches .*\(19, 16\)"),
        ({"host": [0, 1]}, raylign.ShapeError, r"host .*\(20,\)"),
        ({"host": np.full(20, 3)}, raylign.ShapeError, "host"),
        ({"host": "nearest"}, raylign.OptionsError, "'auto'"),
        ({"masks": [None]}, raylign.ShapeError, "3 images but 1 masks"),
        ({"masks": [np.ones((2, 2), bool)] * 3}, raylign.ShapeError, r"masks\[0\]"),
        ({"tracks": np.ones((3, 3), bool)}, raylign.ShapeError, r"tracks .*\(3, 20\)"),
        ({"tracks": [[3, 0]]}, raylign.ShapeError, "track"),
        ({"exposure": [1, 0, 1]}, raylign.OptionsError, "exposure must be"),
        ({"response": np.arange(256)[::-1]}, raylign.OptionsError, "decrease"),
        ({"vignette": np.ones((3, 3))}, raylign.ShapeError, r"vignette is \(3, 3\)"),
        ({"distortion": [0.1]}, raylign.ShapeError, "k1 k2 p1 p2"),
        ({"pose_covariance": -np.eye(6)}, raylign.ShapeError, "covariance"),
    ],
    ids=lambda value: str(list(value)) if isinstance(value, dict) else "",
)  # fmt: skip
def test_bad_input_is_one_clear_error(images, changes, error, message):
    with pytest.raises(error, match=message):
        make(changes.pop("images", images), **changes)


def test_corrections_undo_the_sensor(frames):
    """Response, vignette and exposure: what is compared is irradiance, saturation is masked."""
    truth = frames[0].irradiance
    exposures = [1.0, 0.5, 2.0]
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    falloff = (1.0 - 0.4 * (np.hypot(u - 47, v - 36) / 60) ** 2).astype(np.float32)
    curve = 255.0 * (np.arange(256) / 255.0) ** 2
    raw = []
    for t in exposures:
        light = np.clip(truth * falloff * t, 0, 255)
        raw.append((255.0 * np.sqrt(light / 255.0)).astype(np.float32))
    problem = make(raw, response=curve, vignette=falloff, exposure=exposures)
    assert problem.is_corrected
    inner = raw[2] < 249
    for i in range(3):
        np.testing.assert_allclose(problem.image(i)[inner], truth[inner], atol=0.6)


def test_distorted_images_are_undistorted(images):
    barrel = RadtanCamera(80.0, 82.0, 47.0, 36.0, -0.2, 0.05, 0.0, 0.0)
    problem = make(images, K=barrel)
    assert problem.camera(0) == CAMERA
    expected, _ = image.undistort(images[1], barrel)
    assert np.median(np.abs(problem.image(1) - expected)) < 2.0  # cubic, not linear
    again = make(images, distortion=[-0.2, 0.05, 0.0, 0.0])
    np.testing.assert_array_equal(again.image(1), problem.image(1))


def test_projection(images):
    uv, depth = make(images).project(1)
    p_c = POINTS @ T_CW[1, :3, :3].T + T_CW[1, :3, 3]
    np.testing.assert_allclose(depth, p_c[:, 2])
    np.testing.assert_allclose(uv[:, 0], 80.0 * p_c[:, 0] / p_c[:, 2] + 47.0)
    behind = make(images, points=POINTS * [1, 1, -1])
    assert np.isnan(behind.project(0)[0]).all()


def test_from_text_names_file_and_line(images, tmp_path: Path):
    for i, picture in enumerate(images):
        save_image(tmp_path / f"{i}.png", picture)
    patches = np.full((20, 16), 7.0)
    io.write_patch_points(POINTS, tmp_path / "points.txt", patches=patches)
    io.write_poses(T_CW, tmp_path / "poses.txt")
    files = [tmp_path / "points.txt", tmp_path / "poses.txt"]
    problem = photometric.Problem.from_text(*files, tmp_path, CAMERA)
    np.testing.assert_array_equal(problem.points, POINTS)
    np.testing.assert_array_equal(problem.timestamps, [0, 1, 2])
    assert problem.patch_size == 16
    lines = files[0].read_text().splitlines()
    lines[6] = lines[6].rsplit(" ", 1)[0]
    files[0].write_text("\n".join(lines))
    expected = r"points.txt:7: 19 numbers expected but 18 found in line 7"
    with pytest.raises(raylign.FormatError, match=expected):
        photometric.Problem.from_text(*files, tmp_path, CAMERA)
    (tmp_path / "1.png").unlink()
    files[0].write_text("0 0 1\n1 0 2\n")
    with pytest.raises(raylign.FormatError, match=r"3 images expected but 2 found, 1.png is miss"):
        photometric.Problem.from_text(*files, tmp_path, CAMERA)


def test_points_from_depth_lie_on_the_surface():
    camera, scene = PinholeCamera(200.0, 205.0, 118.0, 91.0), synthetic.room(seed=2)
    frames = [synthetic.render(scene, camera, T, width=240, height=180) for T in T_CW]
    images, depths = [frame.image for frame in frames], [frame.depth for frame in frames]
    problem = photometric.Problem.from_depth(images, depths, camera, T_CW, 150)
    assert 140 <= problem.num_points <= 150
    hosts = problem._arrays["hosts"]
    assert set(hosts) == {0, 1, 2}
    for i, frame in enumerate(frames):
        mine = np.flatnonzero(hosts == i)
        uv, z = problem.project(i, points=problem.points[mine])
        at = np.rint(uv).astype(int)
        np.testing.assert_allclose(uv, at, atol=1e-9)
        np.testing.assert_allclose(z, frame.depth[at[:, 1], at[:, 0]], rtol=1e-12)
        cosine = np.sum(problem._arrays["normals"][mine] * frame.normal[at[:, 1], at[:, 0]], axis=1)
        assert np.quantile(cosine, 0.02) > 0.95
        assert np.median(cosine) > 1.0 - 1e-9
        assert len(np.unique(at, axis=0)) == len(at)


def test_points_from_depth_avoid_edges_and_holes():
    flat = np.random.default_rng(0).uniform(0, 255, (HEIGHT, WIDTH)).astype(np.float32)
    depth = np.full((HEIGHT, WIDTH), 2.0, np.float32)
    depth[:, 48:] = 3.0
    depth[30:40, 10:20] = np.nan
    model = raylign.depth.DepthModel()
    problem = photometric.Problem.from_depth(
        [flat] * 2, [depth] * 2, CAMERA, T_CW[:2], 100, depth_model=model
    )
    u, v = problem._arrays["host_uv"].T
    assert (np.abs(u - 47.5) > 4).all()
    assert not ((u > 5) & (u < 24) & (v > 25) & (v < 44)).any()
    assert problem.has_depth_prior
    sigma = problem._arrays["depth_sigmas"][u < 48]
    np.testing.assert_allclose(sigma, 4.0 * model.inverse_depth_sigma([2.0])[0], rtol=1e-5)
    grey = np.full((HEIGHT, WIDTH), 9, np.uint8)
    with pytest.raises(raylign.OptionsError, match="gradient of 6"):
        photometric.Problem.from_depth([grey] * 2, [depth] * 2, CAMERA, T_CW[:2])
    with pytest.raises(raylign.ShapeError, match="2 images, 1 depths"):
        photometric.Problem.from_depth([flat] * 2, [depth], CAMERA, T_CW[:2])


def test_patterns():
    pattern = photometric.PatchPattern.parse("4x4")
    assert pattern.size == 16
    assert pattern.offsets[:3].tolist() == [[-2, -2], [-2, -1], [-2, 0]]  # by columns
    assert photometric.PhotometricOptions(pattern="spread8").pattern.size == 8
    assert photometric.PatchPattern(pattern.offsets).name == "4x4"
    assert photometric.PatchPattern([[0, 0], [1, 0.5]]).name == "custom"
    with pytest.raises(raylign.OptionsError, match="9x9"):
        photometric.PhotometricOptions(pattern="9x9")
    with pytest.raises(raylign.OptionsError, match="1 and 32 pixels, got 40"):
        photometric.PatchPattern(np.zeros((40, 2)))
    with pytest.raises(raylign.ShapeError, match="offsets"):
        photometric.PatchPattern([1.0, 2.0])


def test_the_exercise_preset_pastes_back():
    options = photometric.preset("exercise").options
    names = {**vars(raylign._core), "float": float}
    assert eval(repr(options), names) == options
    with pytest.raises(raylign.OptionsError, match="'best'"):
        photometric.preset("best")
