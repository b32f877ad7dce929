"""Depth sensors: the façade; the laws and the edges are tested in tests/cpp/depth."""

import numpy as np
import pytest

from raylign import OptionsError, ShapeError, depth
from raylign.depth import DepthModel, DepthNoise


def test_inverse_depth_of_a_crop_equals_the_crop_of_it():
    rng = np.random.default_rng(0)
    Z = rng.uniform(0.5, 5.0, (24, 31)).astype(np.float32)
    model = DepthModel(edge_ratio=0.0)
    D, V = depth.inverse_depth(Z, model=model)
    D_crop, V_crop = depth.inverse_depth(Z[3:20, 5:30], model=model)
    np.testing.assert_array_equal(D_crop, D[3:20, 5:30])
    np.testing.assert_array_equal(V_crop, V[3:20, 5:30])


def test_millimetres_and_metres_agree():
    mm = np.array([[0, 500, 1000, 65535]], np.uint16)
    D, _ = depth.inverse_depth(mm, model=DepthModel(edge_ratio=0.0))
    np.testing.assert_allclose(D, [[0.0, 2.0, 1.0, 0.0]], rtol=1e-6)


@pytest.mark.parametrize("noise", list(DepthNoise))
def test_sigma_scales_the_standard_deviation(noise):
    once = DepthModel(noise=noise, sigma=0.1, focal_baseline=100.0)
    twice = once.replace(sigma=0.2)
    Z = np.array([0.7, 2.0, 5.0])
    np.testing.assert_allclose(twice.inverse_depth_sigma(Z), 2 * once.inverse_depth_sigma(Z))


def test_disparity_goes_there_and_back():
    d = np.array([[40.0, 0.0, -1.0, np.nan]])
    Z = depth.from_disparity(d, focal_baseline=80.0)
    np.testing.assert_array_equal(Z, np.float32([[2.0, 0.0, 0.0, 0.0]]))


def test_wrong_input_is_refused():
    with pytest.raises(ShapeError, match="depth must be"):
        depth.inverse_depth(np.zeros((4, 4), np.float64))
    with pytest.raises(ShapeError, match="one channel"):
        depth.inverse_depth(np.zeros((4, 4, 3), np.float32))
    with pytest.raises(OptionsError, match="depth_scale must be > 0"):
        depth.inverse_depth(np.zeros((4, 4), np.uint16), depth_scale=-1.0)
    with pytest.raises(OptionsError, match="focal_baseline"):
        DepthModel(noise=DepthNoise.DISPARITY)
