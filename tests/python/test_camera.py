"""Cameras through NumPy, with OpenCV's calib3d as the oracle of the Brown-Conrady model."""

import copy
import pickle

import cv2
import numpy as np
import pytest

import raylign
from raylign.camera import BalCamera, PinholeCamera, RadtanCamera, undistort_map

# TUM RGB-D freiburg1 (Sturm et al. 2012).
TUM_FR1 = RadtanCamera(517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633)
EUROC = RadtanCamera(
    458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05
)
CAMERAS = {
    "pinhole": PinholeCamera(718.856, 718.856, 607.1928, 185.2157),
    "tum_fr1": TUM_FR1,
    "euroc": EUROC,
    "bal": BalCamera(399.75, -0.12, 0.01),
}


@pytest.fixture(params=list(CAMERAS))
def camera(request):
    return CAMERAS[request.param]


def grid(camera) -> np.ndarray:
    low, high = (
        ((-300, -200), (300, 200)) if isinstance(camera, BalCamera) else ((0, 0), (639, 479))
    )
    u, v = np.meshgrid(np.linspace(low[0], high[0], 9), np.linspace(low[1], high[1], 7))
    return np.stack([u, v], axis=-1)


def opencv_parts(camera: RadtanCamera) -> tuple[np.ndarray, np.ndarray]:
    fx, fy, cx, cy = camera.params[:4]
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), camera.params[4:]


def test_project_inverts_unproject(camera):
    uv = grid(camera)
    bearing, valid = camera.unproject(uv)
    assert valid.all()
    assert bearing.shape == (7, 9, 3)
    np.testing.assert_allclose(np.linalg.norm(bearing, axis=-1), 1.0, atol=1e-15)
    back, valid = camera.project(5.0 * bearing)
    assert valid.all()
    np.testing.assert_allclose(back, uv, rtol=0, atol=1e-10)
    assert camera.is_in_front(bearing).all()
    assert not camera.is_in_front(-bearing).any()


def test_jacobians_are_the_derivatives(camera):
    p_c = 3.0 * camera.unproject(grid(camera))[0]
    uv, valid, J_point, J_params = camera.project_with_jacobians(p_c)
    assert valid.all()
    assert J_point.shape == (7, 9, 2, 3)
    assert J_params.shape == (7, 9, 2, camera.num_params)
    assert np.array_equal(uv, camera.project(p_c)[0])
    for i, step in enumerate(1e-6 * np.eye(3)):
        difference = (camera.project(p_c + step)[0] - camera.project(p_c - step)[0]) / 2e-6
        np.testing.assert_allclose(J_point[..., i], difference, rtol=1e-6, atol=1e-6)
    for i in range(camera.num_params):
        step = 1e-6 * np.eye(camera.num_params)[i]
        forward, backward = (type(camera)(*(camera.params + s)) for s in (step, -step))
        difference = (forward.project(p_c)[0] - backward.project(p_c)[0]) / 2e-6
        np.testing.assert_allclose(J_params[..., i], difference, rtol=1e-6, atol=1e-6)


def test_unproject_jacobians_are_the_derivatives(camera):
    uv = grid(camera)[1:-1, 1:-1]
    bearing, _, J_uv, J_params = camera.unproject_with_jacobians(uv)
    assert J_uv.shape == (5, 7, 3, 2)
    assert J_params.shape == (5, 7, 3, camera.num_params)
    assert np.array_equal(bearing, camera.unproject(uv)[0])
    for i, step in enumerate(1e-3 * np.eye(2)):
        difference = (camera.unproject(uv + step)[0] - camera.unproject(uv - step)[0]) / 2e-3
        np.testing.assert_allclose(J_uv[..., i], difference, rtol=0, atol=1e-9)
    for i in range(camera.num_params):
        step = 1e-5 * np.eye(camera.num_params)[i]
        forward, backward = (type(camera)(*(camera.params + s)) for s in (step, -step))
        difference = (forward.unproject(uv)[0] - backward.unproject(uv)[0]) / 2e-5
        np.testing.assert_allclose(J_params[..., i], difference, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("camera", [TUM_FR1, EUROC], ids=["tum_fr1", "euroc"])
def test_radtan_agrees_with_opencv(camera):
    K, distortion = opencv_parts(camera)
    p_c = 2.0 * camera.unproject(grid(camera).reshape(-1, 2))[0]
    uv, _, _, J_params = camera.project_with_jacobians(p_c)
    expected, jacobian = cv2.projectPoints(p_c, np.zeros(3), np.zeros(3), K, distortion)
    np.testing.assert_allclose(uv, expected[:, 0], rtol=0, atol=1e-10)
    # OpenCV's columns: rotation 0-2, translation 3-5, f 6-7, c 8-9, (k1, k2, p1, p2, k3) 10-14.
    np.testing.assert_allclose(J_params, jacobian[:, 6:15].reshape(-1, 2, 9), rtol=0, atol=1e-9)


@pytest.mark.parametrize("batch", [(), (0,), (4,), (2, 3)])
def test_batch_shapes(camera, batch):
    p_c = np.ones((*batch, 3))
    uv, valid = camera.project(p_c)
    assert uv.shape == (*batch, 2)
    assert valid.shape == batch
    assert valid.dtype == np.bool_
    bearing, valid, J_uv, J_params = camera.unproject_with_jacobians(uv)
    assert bearing.shape == (*batch, 3)
    assert J_uv.shape == (*batch, 3, 2)
    assert J_params.shape == (*batch, 3, camera.num_params)


def test_points_without_projection_are_nan(camera):
    sign = -1.0 if isinstance(camera, BalCamera) else 1.0
    p_c = np.array([[0.1, 0.1, sign], [0.1, 0.1, 0.0], [0.1, 0.1, -sign], [0.1, 0.1, np.nan]])
    uv, valid, J_point, J_params = camera.project_with_jacobians(p_c)
    assert valid.tolist() == [True, False, isinstance(camera, BalCamera), False]
    for array in (uv, J_point, J_params):
        assert np.isfinite(array[valid]).all()
        assert np.isnan(array[~valid]).all()


def test_pixels_without_ray_are_nan():
    bearing, valid = BalCamera(100.0, -0.25, 0.0).unproject([[10.0, 0.0], [1e4, 0.0]])
    assert valid.tolist() == [True, False]
    assert np.isnan(bearing[1]).all()


def test_bal_convention():
    uv, _ = BalCamera(100.0).project([1.0, 2.0, -4.0])
    assert uv.tolist() == [25.0, 50.0]


def test_values(camera):
    names = camera.__fields__
    assert [getattr(camera, name) for name in names] == camera.params.tolist()
    assert len(names) == camera.num_params
    for twin in (
        eval(repr(camera)),
        type(camera)(*camera.params),
        type(camera)(**dict(zip(names, camera.params.tolist(), strict=True))),
        pickle.loads(pickle.dumps(camera)),
        copy.copy(camera),
        copy.deepcopy(camera),
    ):
        assert twin == camera
        assert hash(twin) == hash(camera)
        assert twin is not camera
    params = camera.params.copy()
    params[-1] += 1.0
    assert type(camera)(*params) != camera
    assert camera != "camera"
    with pytest.raises(AttributeError):
        setattr(camera, names[0], 1.0)


def test_matrix_of_the_pinhole():
    assert PinholeCamera(2.0, 3.0, 4.0, 5.0).matrix().tolist() == [[2, 0, 4], [0, 3, 5], [0, 0, 1]]


def test_impossible_parameters_are_refused(camera):
    for i in range(camera.num_params):
        params = camera.params.copy()
        params[i] = np.nan
        with pytest.raises(raylign.OptionsError, match=f"{camera.__fields__[i]} must be"):
            type(camera)(*params)
    with pytest.raises(raylign.OptionsError, match="must be > 0"):
        type(camera)(*(camera.params * [-1.0] + 0.0))


@pytest.mark.parametrize("bad", [np.zeros(2), np.zeros((3, 2)), "abc", None, np.zeros(3, complex)])
def test_wrong_shapes_are_refused(camera, bad):
    with pytest.raises(raylign.ShapeError, match="p_c must be"):
        camera.project(bad)


class TestUndistortMap:
    @pytest.mark.parametrize("camera", [TUM_FR1, EUROC], ids=["tum_fr1", "euroc"])
    def test_agrees_with_opencv(self, camera):
        K, distortion = opencv_parts(camera)
        K_new = K + np.array([[-40.0, 0, 5.0], [0, -30.0, -7.0], [0, 0, 0]])
        map_x, map_y = undistort_map(camera, K_new, width=320, height=240)
        expected_x, expected_y = cv2.initUndistortRectifyMap(
            K, distortion, None, K_new, (320, 240), cv2.CV_32FC1
        )
        assert map_x.dtype == map_y.dtype == np.float32
        np.testing.assert_allclose(map_x, expected_x, rtol=0, atol=1e-4)
        np.testing.assert_allclose(map_y, expected_y, rtol=0, atol=1e-4)

    def test_pixels_beyond_the_fold_are_outside(self):
        camera = RadtanCamera(100.0, 100.0, 50.0, 50.0, -0.25, 0.0, 0.0, 0.0)
        K_new = PinholeCamera(10.0, 10.0, 50.0, 50.0).matrix()
        map_x, map_y = undistort_map(camera, K_new, width=101, height=101)
        assert map_x[0, 0] == map_y[0, 0] == -1e4
        assert map_x[50, 50] == map_y[50, 50] == 50.0

    def test_refuses_bad_input(self):
        camera = CAMERAS["pinhole"]
        with pytest.raises(raylign.OptionsError, match="invertible"):
            undistort_map(camera, np.zeros((3, 3)), width=4, height=4)
        with pytest.raises(raylign.ShapeError, match="width"):
            undistort_map(camera, np.eye(3), width=0, height=4)
        with pytest.raises(raylign.ShapeError, match="K_new"):
            undistort_map(camera, np.eye(4), width=4, height=4)
        with pytest.raises(raylign.ShapeError, match="K_new"):
            undistort_map(camera, np.eye(3)[None], width=4, height=4)
        with pytest.raises(TypeError):
            undistort_map(BalCamera(1.0), np.eye(3), width=4, height=4)
