"""Grey values, pyramids, gradients: against NumPy and cv2, over the images people have."""

import gc
import math

import cv2
import numpy as np
import pytest

import raylign
from raylign.camera import PinholeCamera
from raylign.image import (
    ColorOrder,
    DepthPyramid,
    DepthPyramidOptions,
    ImagePyramid,
    PyramidOptions,
    gradient_image,
    max_gradient,
    to_grey,
)

SIZES = [(1, 1), (1, 9), (7, 1), (16, 16), (17, 33), (479, 641)]
DTYPES = [np.uint8, np.uint16, np.float32]


def noise(shape: tuple[int, ...], dtype: type = np.float32) -> np.ndarray:
    rng = np.random.default_rng([3, *shape])
    if dtype == np.float32:
        return rng.uniform(0, 255, shape).astype(np.float32)
    return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("shape", SIZES)
def test_grey_of_one_channel(shape, dtype):
    image = noise(shape, dtype)
    divisor = np.float32(257 if dtype == np.uint16 else 1)
    assert np.array_equal(to_grey(image), image.astype(np.float32) / divisor)


@pytest.mark.parametrize("dtype", DTYPES)
def test_grey_of_color_is_that_of_cv2(dtype):
    image = noise((31, 45, 3), dtype)
    scale = 257.0 if dtype == np.uint16 else 1.0
    wide = image.astype(np.float32)
    for order, code in [
        (ColorOrder.RGB, cv2.COLOR_RGB2GRAY),
        (ColorOrder.BGR, cv2.COLOR_BGR2GRAY),
    ]:
        expected = cv2.cvtColor(wide, code) / scale
        np.testing.assert_allclose(to_grey(image, color_order=order), expected, atol=1e-4)


def test_grey_is_a_copy():
    image = noise((5, 6))
    grey = to_grey(image)
    grey[:] = 0.0
    assert image.max() > 0.0


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("shape", SIZES)
def test_levels_are_box_means(shape, dtype):
    pyramid = ImagePyramid(noise(shape, dtype), options=PyramidOptions(max_levels=20, min_side=1))
    level = to_grey(noise(shape, dtype))
    assert len(pyramid) == int(math.log2(min(shape))) + 1
    for found in pyramid:
        assert np.array_equal(found, level)
        h, w = level.shape[0] // 2, level.shape[1] // 2
        if min(h, w) > 0:
            q = level[: 2 * h, : 2 * w].reshape(h, 2, w, 2)
            level = np.float32(0.25) * (q[:, 0].sum(axis=2) + q[:, 1].sum(axis=2))


def test_default_levels():
    assert [p.shape for p in ImagePyramid(np.zeros((480, 640), np.uint8))] == [
        (480, 640),
        (240, 320),
        (120, 160),
        (60, 80),
        (30, 40),
    ]
    assert len(ImagePyramid(np.zeros((3000, 4000), np.uint8))) == 5
    assert len(ImagePyramid(np.zeros((1, 1), np.uint8))) == 1
    assert len(ImagePyramid(np.zeros((31, 31), np.uint8))) == 1
    assert len(ImagePyramid(np.zeros((32, 33), np.uint8))) == 2


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 3])
def test_crops_are_read_in_place(dtype, channels):
    whole = noise((60, 83) if channels == 1 else (60, 83, 3), dtype)
    crop = whole[7:50, 11:72]
    assert not crop.flags.c_contiguous
    for a, b in zip(ImagePyramid(crop), ImagePyramid(crop.copy()), strict=True):
        assert np.array_equal(a, b)
    assert np.array_equal(gradient_image(crop), gradient_image(crop.copy()))
    assert np.array_equal(max_gradient(crop), max_gradient(crop.copy()))


def test_levels_are_read_only_and_keep_the_pyramid_alive():
    level = ImagePyramid(np.full((32, 32), 7, np.uint8))[1]
    gc.collect()
    assert level.tolist() == [[7.0] * 16] * 16
    assert not level.flags.writeable
    assert not level.flags.owndata


def test_assign_shows_the_new_image_in_the_old_arrays():
    options = PyramidOptions(max_levels=3, min_side=4)
    pyramid = ImagePyramid(noise((40, 52)), options=options)
    levels = list(pyramid)
    new = noise((40, 52, 3), np.uint8)
    pyramid.assign(new, color_order=ColorOrder.BGR)
    fresh = ImagePyramid(new, options=options, color_order=ColorOrder.BGR)
    assert len(pyramid) == len(fresh) == 3
    for old, expected in zip(levels, fresh, strict=True):
        assert np.array_equal(old, expected)
    with pytest.raises(raylign.ShapeError, match=r"\(40, 52\), got uint8 \(52, 40\)"):
        pyramid.assign(np.zeros((52, 40), np.uint8))


def test_level_indices():
    pyramid = ImagePyramid(np.zeros((64, 64), np.uint8))
    assert pyramid.num_levels == len(pyramid) == 3
    assert pyramid[-1].shape == (16, 16)
    for bad in (3, -4):
        with pytest.raises(IndexError):
            pyramid[bad]


def test_missing_pixels_stay_local():
    image = np.full((8, 8), 50.0, np.float32)
    image[5, 3] = np.nan
    level = ImagePyramid(image, options=PyramidOptions(min_side=1))[1]
    assert np.argwhere(np.isnan(level)).tolist() == [[2, 1]]
    assert np.argwhere(np.isnan(gradient_image(image)[..., 1])).tolist() == [[5, 2], [5, 4]]
    assert max_gradient(image).max() == 0.0


@pytest.mark.parametrize("level", range(5))
def test_camera_of_a_level_sees_what_the_filter_kept(level):
    """A slow wave over the rays: at the wrong half pixel it would be off by a grey level."""

    def wave(camera, shape):
        v, u = np.mgrid[: shape[0], : shape[1]]
        phase = 9.0 * (u - camera.cx) / camera.fx + 5.0 * (v - camera.cy) / camera.fy
        return 128.0 + 100.0 * np.sin(phase)

    camera = PinholeCamera(525.0, 520.0, 321.3, 236.8)
    pyramid = ImagePyramid(wave(camera, (480, 640)).astype(np.float32))
    found = pyramid[level]
    # Each averaging damps a wave of k rad/px by cos(k/2) per axis; the phase stays.
    damping = math.prod(
        math.cos(9.0 / 525.0 * 2**i / 2) * math.cos(5.0 / 520.0 * 2**i / 2) for i in range(level)
    )
    expected = 128.0 + damping * (wave(camera.at_level(level), found.shape) - 128.0)
    np.testing.assert_allclose(found, expected, atol=1e-3)


@pytest.mark.parametrize("shape", [(2, 2), (2, 9), (17, 33), (479, 641)])
def test_gradient_is_that_of_numpy(shape):
    image = noise(shape, np.uint8)
    cells = gradient_image(image)
    dv, du = np.gradient(image.astype(np.float64))
    assert cells.shape == (*shape, 4)
    assert cells.dtype == np.float32
    assert np.array_equal(cells, np.stack([image, du, dv, 0 * du], axis=2))


def test_gradient_along_one_pixel_is_zero():
    assert gradient_image(np.full((1, 1), 3, np.uint8)).tolist() == [[[3.0, 0.0, 0.0, 0.0]]]
    assert not gradient_image(noise((1, 9)))[..., 2].any()
    assert not gradient_image(noise((9, 1)))[..., 1].any()


@pytest.mark.parametrize("shape", SIZES)
def test_max_gradient_is_a_dilation(shape):
    image = noise(shape)
    cells = gradient_image(image)
    expected = cv2.dilate(np.hypot(cells[..., 1], cells[..., 2]), np.ones((3, 3), np.uint8))
    np.testing.assert_allclose(max_gradient(image), expected, rtol=1e-6)


def depth_maps(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng([5, *shape])
    D = rng.uniform(0.2, 1.0, shape).astype(np.float32)
    V = rng.uniform(1e-5, 1e-3, shape).astype(np.float32)
    for array, bad in [(D, 0), (D, np.nan), (D, np.inf), (V, 0), (V, -1), (V, np.nan), (V, np.inf)]:
        array[rng.random(shape) < 0.08] = bad
    return D, V


@pytest.mark.parametrize("shape", SIZES)
def test_depth_pyramid_follows_its_formula(shape):
    D, V = depth_maps(shape)
    pyramid = DepthPyramid(
        D, V, options=DepthPyramidOptions(pyramid=PyramidOptions(max_levels=9, min_side=1))
    )
    valid = np.isfinite(D) & np.isfinite(V) & (D > 0) & (V > 0)
    D, V = np.where(valid, D, 0), np.where(valid, V, 0)
    for found_D, found_V in pyramid:
        np.testing.assert_allclose(found_D, D, rtol=1e-5)
        np.testing.assert_allclose(found_V, V, rtol=1e-5)
        h, w = D.shape[0] // 2, D.shape[1] // 2
        if min(h, w) == 0:
            continue
        D, V = (
            a[: 2 * h, : 2 * w].reshape(h, 2, w, 2).transpose(0, 2, 1, 3).reshape(h, w, 4)
            for a in (D.astype(float), V.astype(float))
        )
        weight = np.divide(1.0, V, out=np.zeros_like(V), where=V > 0)
        total, n = weight.sum(axis=2), (V > 0).sum(axis=2)
        D = np.divide((weight * D).sum(axis=2), total, out=np.zeros((h, w)), where=n > 0)
        V = np.divide(n, total, out=np.zeros((h, w)), where=n > 0)


def test_depth_edges():
    D, V = np.full((2, 16, 16), np.float32(0.01))
    D[:, :5], D[:, 5:] = 1.0, 0.5
    options = DepthPyramidOptions(pyramid=PyramidOptions(min_side=4), max_depth_ratio=1.5)
    assert (DepthPyramid(D, V)[0][0] == D).all()
    coarse, _ = DepthPyramid(D, V, options=options.replace(max_depth_ratio=math.inf))[1]
    assert coarse[3].tolist() == [1.0, 1.0, 0.75, 0.5, 0.5, 0.5, 0.5, 0.5]
    coarse, variance = DepthPyramid(D, V, options=options)[1]
    assert coarse[3].tolist() == [1.0, 1.0, 0.0, 0.5, 0.5, 0.5, 0.5, 0.5]
    assert (variance > 0).all(axis=0).tolist() == [True, True, False] + [True] * 5


BAD_IMAGES = [
    np.zeros((4, 4)),
    np.zeros((4, 4), np.int32),
    np.zeros((4, 4, 2), np.uint8),
    np.zeros((4, 4, 4), np.uint8),
    np.zeros(4, np.uint8),
    np.zeros((0, 4), np.uint8),
    np.zeros((4, 8), np.uint8)[:, ::2],
    np.zeros((4, 4), np.uint8)[::-1],
    np.zeros((4, 4), ">u2"),
    np.frombuffer(bytes(65), np.uint8)[1:].view(np.float32).reshape(4, 4),  # not aligned
    [[1, 2], [3, 4]],
    None,
]


@pytest.mark.parametrize("image", BAD_IMAGES)
@pytest.mark.parametrize("function", [to_grey, gradient_image, max_gradient, ImagePyramid])
def test_images_that_are_refused(function, image):
    with pytest.raises(raylign.ShapeError, match="image must be"):
        function(image)


def test_depth_that_is_refused():
    D = np.ones((4, 4), np.float32)
    for bad in (D.astype(np.float64), D[:3], np.ones((4, 4, 3), np.float32), D[:, ::2], None):
        with pytest.raises(raylign.ShapeError):
            DepthPyramid(D, bad)
        with pytest.raises(raylign.ShapeError):
            DepthPyramid(bad, D)


def test_options_that_are_refused():
    with pytest.raises(raylign.OptionsError, match=r"max_levels must be >= 1, got 0"):
        PyramidOptions(max_levels=0)
    with pytest.raises(raylign.OptionsError, match=r"min_side must be >= 1, got 0"):
        PyramidOptions(min_side=0)
    with pytest.raises(raylign.OptionsError, match=r"max_depth_ratio must be > 1, got 1"):
        DepthPyramidOptions(max_depth_ratio=1.0)
    with pytest.raises(raylign.OptionsError, match="level must be >= 0"):
        PinholeCamera(1.0, 1.0, 0.0, 0.0).at_level(-1)
