"""remap, and the two OpenCVs (Debian's in `_core`, the wheel's `cv2`) in one process."""

import subprocess
import sys

import cv2
import numpy as np
import pytest

import raylign
from raylign.image import Interpolation, remap


def random_image(dtype, channels: int) -> np.ndarray:
    rng = np.random.default_rng([7, channels])
    shape = (48, 64) if channels == 1 else (48, 64, 3)
    if dtype == np.float32:
        return rng.uniform(0, 255, shape).astype(dtype)
    return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


def wavy_maps() -> tuple[np.ndarray, np.ndarray]:
    """Also leaves the image on all sides."""
    v, u = np.mgrid[0:40, 0:70].astype(np.float32)
    return u + 3 * np.sin(v / 5) - 2, v * 1.3 + 2 * np.cos(u / 7) - 1


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(
    ("interpolation", "flag"),
    [
        (Interpolation.NEAREST, cv2.INTER_NEAREST),
        (Interpolation.LINEAR, cv2.INTER_LINEAR),
        (Interpolation.CUBIC, cv2.INTER_CUBIC),
    ],
)
def test_agrees_with_the_wheel(dtype, channels, interpolation, flag):
    image = random_image(dtype, channels)
    map_x, map_y = wavy_maps()
    result = remap(image, map_x, map_y, interpolation=interpolation)
    assert result.dtype == dtype
    assert result.shape == map_x.shape + image.shape[2:]
    expected = cv2.remap(image, map_x, map_y, flag, borderMode=cv2.BORDER_CONSTANT)
    # The two versions round coordinates differently, by at most 1/32 px: compare the bulk.
    full = 255.0 if dtype != np.uint16 else 65535.0
    difference = np.abs(result.astype(np.float64) - expected) / full
    assert np.median(difference) < 0.01
    assert np.mean(difference > 0.1) < 0.02


def test_reads_a_plane_between_pixels():
    v, u = np.mgrid[0:20, 0:30].astype(np.float32)
    map_x, map_y = np.full((1, 2), 3.25, np.float32), np.full((1, 2), 7.5, np.float32)
    assert remap(4 * u + 2 * v, map_x, map_y).tolist() == [[28.0, 28.0]]


def test_outside_and_nan_are_zero():
    image = np.full((10, 10), 200, np.uint8)
    map_x = np.float32([[-1e4, np.nan, np.inf, 5.0]])
    assert remap(image, map_x, np.full((1, 4), 5, np.float32)).tolist() == [[0, 0, 0, 200]]


def test_a_crop_is_read_in_place():
    image = random_image(np.uint8, 3)
    crop = image[5:30, 10:50]
    map_x, map_y = wavy_maps()
    assert np.array_equal(remap(crop, map_x, map_y), remap(crop.copy(), map_x, map_y))


def test_result_owns_its_pixels():
    result = remap(np.ones((4, 4), np.float32), *np.zeros((2, 3, 3), np.float32))
    assert result.base is not None
    result += 1.0
    assert result.flags.writeable
    assert result.tolist() == [[2.0] * 3] * 3


GOOD_MAP = np.zeros((3, 3), np.float32)


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((4, 4)),
        np.zeros((4, 4), np.int32),
        np.zeros((4, 4), bool),
        np.zeros((4, 4, 2), np.uint8),
        np.zeros((4, 4, 4), np.uint8),
        np.zeros(4, np.uint8),
        np.zeros((0, 4), np.uint8),
        np.zeros((4, 8), np.uint8)[:, ::2],
        np.zeros((4, 4), np.uint8)[::-1],
        np.zeros((4, 4), np.uint8).T[:, :3],
        np.zeros((1, 40000), np.uint8),
        np.zeros((4, 4), ">u2"),
        [[1, 2], [3, 4]],
        None,
    ],
)
def test_images_that_are_refused(image):
    with pytest.raises(raylign.ShapeError):
        remap(image, GOOD_MAP, GOOD_MAP)


@pytest.mark.parametrize(
    ("map_x", "map_y"),
    [
        (np.zeros((3, 3)), GOOD_MAP),
        (GOOD_MAP, np.zeros((3, 4), np.float32)),
        (np.zeros((3, 6), np.float32)[:, ::2], GOOD_MAP),
        (np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32)),
        (np.zeros(3, np.float32), np.zeros(3, np.float32)),
    ],
)
def test_maps_that_are_refused(map_x, map_y):
    with pytest.raises(raylign.ShapeError):
        remap(np.zeros((4, 4), np.uint8), map_x, map_y)


TWO_OPENCVS = """
{imports}
import numpy as np
from raylign.camera import RadtanCamera, undistort_map
from raylign.image import remap

v, u = np.mgrid[0:96, 0:128].astype(np.float32)
image = 127.0 + 60.0 * np.sin(u / 9.0) + 60.0 * np.cos(v / 11.0)
camera = RadtanCamera(110.0, 112.0, 63.0, 47.0, -0.28, 0.07, 0.0002, 0.0001, 0.0)
K = np.array([[110.0, 0, 63.0], [0, 112.0, 47.0], [0, 0, 1]])
map_x, map_y = undistort_map(camera, K, width=128, height=96)
for _ in range(3):
    ours = remap(image, map_x, map_y)
    theirs = cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR)
    whole = cv2.undistort(image, K, camera.params[4:])
print(cv2.__version__, np.abs(ours - theirs).max(), np.abs(ours - whole).max(), ours.std())
assert np.abs(ours - theirs).max() < 0.5
assert np.abs(ours - whole).max() < 0.5
assert ours.std() > 20.0
"""


@pytest.mark.parametrize("imports", ["import cv2\nimport raylign", "import raylign\nimport cv2"])
def test_both_opencvs_in_one_process(imports):
    code = TWO_OPENCVS.format(imports=imports)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr == ""
