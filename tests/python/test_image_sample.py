"""Values and gradients between pixels; undistortion."""

import cv2
import numpy as np
import pytest

import raylign
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.image import (
    BSplineImage,
    ColorOrder,
    Interpolation,
    SampleInterpolation,
    Undistorter,
    gradient_image,
    inscribed_camera,
    sample,
    to_grey,
    undistort,
)

BILINEAR = SampleInterpolation.BILINEAR
CENTRAL = SampleInterpolation.CENTRAL_DIFFERENCE
BSPLINE = SampleInterpolation.CUBIC_BSPLINE
RNG = np.random.default_rng(17)
IMAGE = RNG.uniform(0, 255, (41, 57)).astype(np.float32)
UV = RNG.uniform([0.0, 0.0], [56.0, 40.0], (500, 2))
BETWEEN = np.floor(UV) + 0.05 + 0.9 * (UV - np.floor(UV))  # a step of 0.01 stays in its cell


def differences(uv: np.ndarray, step: float, interpolation: SampleInterpolation) -> np.ndarray:
    """Central differences of the sampled values, Richardson-extrapolated."""

    def slope(h: float, axis: int) -> np.ndarray:
        offset = np.eye(2)[axis] * h
        right, _, _ = sample(IMAGE, uv + offset, interpolation=interpolation)
        left, _, _ = sample(IMAGE, uv - offset, interpolation=interpolation)
        return (right - left) / (2 * h)

    return np.stack([(4 * slope(step / 2, a) - slope(step, a)) / 3 for a in (0, 1)], axis=1)


@pytest.mark.parametrize("interpolation", [BILINEAR, BSPLINE])
def test_gradient_is_the_derivative_of_the_value(interpolation):
    _, gradients, valid = sample(IMAGE, BETWEEN, interpolation=interpolation)
    assert valid.all()
    np.testing.assert_allclose(gradients, differences(BETWEEN, 0.01, interpolation), atol=1e-6)


def test_bilinear_is_that_of_cv2():
    values, _, _ = sample(IMAGE, UV)
    u, v = UV.astype(np.float32).T[:, None]
    expected = cv2.remap(IMAGE, u, v, cv2.INTER_LINEAR)[0]
    assert np.abs(values - expected).max() < 255 * 2 / 32  # cv2 rounds coordinates to 1/32 px
    f, g = np.modf(UV)[0].T
    i, j = np.floor(UV).astype(int).T
    image = IMAGE.astype(float)
    top = (1 - f) * image[j, i] + f * image[j, i + 1]
    bottom = (1 - f) * image[j + 1, i] + f * image[j + 1, i + 1]
    np.testing.assert_allclose(values, (1 - g) * top + g * bottom, rtol=1e-13)


def test_central_difference_interpolates_the_cells():
    cells = gradient_image(IMAGE)
    values, gradients, _ = sample(IMAGE, UV, interpolation=CENTRAL)
    for found, channel in [(values, 0), (gradients[:, 0], 1), (gradients[:, 1], 2)]:
        expected, _, _ = sample(np.ascontiguousarray(cells[..., channel]), UV)
        np.testing.assert_allclose(found, expected, atol=1e-10)


def test_spline_is_that_of_scipy():
    ndimage = pytest.importorskip("scipy.ndimage")
    spline = BSplineImage(IMAGE)
    values, _, _ = spline.sample(UV)
    expected = ndimage.map_coordinates(IMAGE.astype(float), UV.T[::-1], order=3, mode="mirror")
    np.testing.assert_allclose(values, expected, atol=2e-4)
    wanted = ndimage.spline_filter(IMAGE.astype(float), order=3, mode="mirror")
    np.testing.assert_allclose(spline.coefficients[1:-2, 1:-2], wanted, atol=3e-4)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 5), (16, 16), (23, 25), (479, 641)])
@pytest.mark.parametrize("interpolation", list(SampleInterpolation))
def test_pixels_are_reproduced(shape, interpolation):
    image = np.random.default_rng([1, *shape]).uniform(0, 255, shape).astype(np.float32)
    v, u = np.mgrid[: shape[0], : shape[1]]
    values, gradients, valid = sample(image, np.stack([u, v], axis=2), interpolation=interpolation)
    assert valid.all()
    assert values.shape == shape
    assert gradients.shape == (*shape, 2)
    np.testing.assert_allclose(values, image, atol=3e-4)


@pytest.mark.parametrize("interpolation", list(SampleInterpolation))
def test_border_rule(interpolation):
    inside = [[0, 0], [56, 40], [0, 40], [56, 0], [55.999, 0.001]]
    outside = [[-1e-9, 5], [56.000001, 5], [5, -1e-9], [5, 40.000001], [1e300, 5]]
    nowhere = [[np.nan, 5], [5, np.nan], [np.inf, 5], [5, -np.inf]]
    values, gradients, valid = sample(
        IMAGE, inside + outside + nowhere, interpolation=interpolation
    )
    assert valid.tolist() == [True] * 5 + [False] * 9
    assert np.isfinite(values[:5]).all()
    assert np.isnan(values[5:]).all()
    assert np.isnan(gradients[5:]).all()


@pytest.mark.parametrize(("interpolation", "reach"), [(BILINEAR, 1), (CENTRAL, 2), (BSPLINE, 2)])
def test_missing_pixels_make_samples_invalid(interpolation, reach):
    image = IMAGE.copy()
    image[20, 30] = np.nan
    v, u = np.mgrid[15:26, 25:36] + 0.5
    uv = np.stack([u, v], axis=2)
    values, _, valid = sample(image, uv, interpolation=interpolation)
    du, dv = np.abs(u - 30), np.abs(v - 20)
    wanted = (du < reach) & (dv < reach)
    if interpolation is CENTRAL:  # the cross of the differences, not the square
        wanted &= (du < 1) | (dv < 1)
    assert np.array_equal(~valid, wanted)
    assert np.isnan(values[~valid]).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("interpolation", list(SampleInterpolation))
def test_every_kind_of_image_is_its_grey_image(dtype, channels, interpolation):
    shape = (30, 40) if channels == 1 else (30, 40, 3)
    full = 255 if dtype != np.uint16 else 65535
    crop = np.random.default_rng(4).uniform(0, full, shape).astype(dtype)[3:25, 5:38]
    arguments = {"interpolation": interpolation, "color_order": ColorOrder.BGR}
    found = sample(crop, UV * 0.5, **arguments)
    expected = sample(to_grey(crop, color_order=ColorOrder.BGR), UV * 0.5, **arguments)
    for a, b in zip(found, expected, strict=True):
        assert np.array_equal(a, b)
    if interpolation is BSPLINE:
        kept = BSplineImage(crop, color_order=ColorOrder.BGR)
        assert np.array_equal(kept.sample(UV * 0.5)[0], expected[0])


def test_shapes_of_points():
    for shape in [(), (3,), (2, 3), (0,)]:
        values, gradients, valid = sample(IMAGE, np.ones((*shape, 2)))
        assert values.shape == valid.shape == shape
        assert gradients.shape == (*shape, 2)
    for bad in (np.ones(3), np.ones((4, 3)), 1.0, [[1, 2], [3]], ["a", "b"]):
        with pytest.raises(raylign.ShapeError, match="uv must be"):
            sample(IMAGE, bad)
    with pytest.raises(raylign.ShapeError, match="image must be"):
        sample(IMAGE.astype(np.float64), UV)
    with pytest.raises(raylign.ShapeError, match="image must be"):
        BSplineImage(IMAGE[:, ::2])


BARREL = RadtanCamera(60.0, 62.0, 28.2, 19.6, -0.25, 0.05, 1e-3, -2e-3)


def test_undistort_agrees_with_cv2():
    smooth = cv2.GaussianBlur(IMAGE, (0, 0), 3.0)
    result, camera = undistort(smooth, BARREL)
    assert camera == PinholeCamera(60.0, 62.0, 28.2, 19.6)
    expected = cv2.undistort(smooth, camera.matrix(), BARREL.params[4:])
    assert np.abs(result - expected)[4:-4, 4:-4].max() < 1.0
    color = np.dstack([IMAGE] * 3).astype(np.uint8)
    assert undistort(color, BARREL)[0].shape == color.shape


def test_undistorted_depth_is_not_mixed():
    depth = np.where(np.arange(57) < 28, 1000, 3000).astype(np.uint16) * np.ones((41, 1), np.uint16)
    result, _ = undistort(depth, BARREL, interpolation=Interpolation.NEAREST)
    assert result.dtype == np.uint16
    assert set(np.unique(result)) <= {0, 1000, 3000}


def test_lines_become_straight():
    """A straight edge in space, imaged with distortion, is straight in the undistorted image."""
    v, u = np.mgrid[0:41, 0:57].astype(np.float64)
    rays, _ = BARREL.unproject(np.stack([u, v], axis=2))
    x, y = rays[..., 0] / rays[..., 2], rays[..., 1] / rays[..., 2]
    image = (128 + 300 * (0.8 * x - 0.3 * y)).astype(np.float32)
    result, camera = undistort(image, BARREL)
    expected = 128 + 300 * (0.8 * (u - camera.cx) / camera.fx - 0.3 * (v - camera.cy) / camera.fy)
    inner = (slice(6, -6), slice(6, -6))
    assert np.abs(result - expected)[inner].max() < 0.2  # 1/64 px of rounding and the curvature


@pytest.mark.parametrize("k1", [-0.3, 0.0, 0.2])
def test_inscribed_camera_has_no_black_border(k1):
    camera = RadtanCamera(60.0, 62.0, 28.2, 19.6, k1, 0.0, 0.0, 0.0)
    fitted = inscribed_camera(camera, width=57, height=41)
    white = np.full((41, 57), 255, np.uint8)
    result, returned = undistort(white, camera, new_camera=fitted)
    assert returned == fitted
    assert (result == 255).all()
    wider = PinholeCamera(fitted.fx * 0.99, fitted.fy * 0.99, fitted.cx, fitted.cy)
    border = np.concatenate([np.mgrid[0:57, 0:41].reshape(2, -1).T])
    uv, valid = camera.project(wider.unproject(border.astype(float))[0])
    assert (~valid | (uv < 0).any(axis=1) | (uv > [56, 40]).any(axis=1)).any()


def test_undistorter_is_reusable_and_checks_sizes():
    undistorter = Undistorter(BARREL, width=57, height=41)
    assert np.array_equal(undistorter(IMAGE), undistort(IMAGE, BARREL)[0])
    with pytest.raises(raylign.ShapeError, match="57 x 41"):
        undistorter(IMAGE.T.copy())
    with pytest.raises(raylign.ShapeError):
        undistorter(IMAGE.astype(np.float64))
    with pytest.raises(raylign.ShapeError):
        undistort(np.zeros(4, np.uint8), BARREL)
    with pytest.raises(raylign.ShapeError):
        undistort(np.zeros((0, 4), np.uint8), BARREL)
