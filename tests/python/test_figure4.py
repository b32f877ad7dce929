"""What figure 4 of LSD-SLAM says of sigma_r, on maps made as `examples/figure4.py` makes them."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt
import pytest

from raylign.geometry import se3_exp

ROOT = Path(__file__).resolve().parents[2]
WIDTH = 161
MAX_FIGURE_BYTES = 300_000
# Plane waves of the paint: wave vector (rad/m), phase, amplitude. None is symmetric to the axis.
WAVES = [((24.0, 10.0), 0.4, 40.0), ((-12.0, 26.0), 1.3, 35.0), ((6.0, 16.0), 2.2, 30.0)]

Map = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def figure4() -> ModuleType:
    spec = importlib.util.spec_from_file_location("figure4", ROOT / "examples" / "figure4.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look themselves up
    spec.loader.exec_module(module)
    return module


def waves(x: Map, y: Map) -> Map:
    return 128.0 + sum(A * np.sin(k[0] * x + k[1] * y + phase) for k, phase, A in WAVES)


def gradient_of_waves(x: Map, y: Map) -> tuple[Map, Map]:
    """Grey levels per m."""
    slopes = [(k, A * np.cos(k[0] * x + k[1] * y + phase)) for k, phase, A in WAVES]
    return sum(k[0] * slope for k, slope in slopes), sum(k[1] * slope for k, slope in slopes)


def turned(x: Map, y: Map) -> Map:
    """The waves, turned by 90 degrees about the optical axis."""
    return waves(-y, x)


def map_of(figure4: ModuleType, T_th: Map, paint=waves) -> Map:
    here = figure4.view(np.eye(4), width=WIDTH, paint=paint)
    there = figure4.view(T_th, width=WIDTH, paint=paint)
    return figure4.normalisation(here, there, T_th, min_gradient=0.0)


def pixels(figure4: ModuleType) -> tuple[Map, Map]:
    """(u, v) less the principal point, px."""
    camera, width, height = figure4.camera_of(WIDTH)
    v, u = np.mgrid[:height, :width].astype(np.float64)
    return u - camera.cx, v - camera.cy


def excess(S: Map) -> Map:
    """1/S − 1 = (dr/dD)² V / (2 σ_I²)."""
    return 1.0 / S - 1.0


def bilinear(image: Map, u: Map, v: Map) -> Map:
    column, row = np.floor(u).astype(int), np.floor(v).astype(int)
    f, g = u - column, v - row
    upper = (1 - f) * image[row, column] + f * image[row, column + 1]
    lower = (1 - f) * image[row + 1, column] + f * image[row + 1, column + 1]
    return (1 - g) * upper + g * lower


def test_rotation_weighs_all_pixels_alike(figure4: ModuleType):
    S = map_of(figure4, figure4.MOTIONS["rotation"])
    assert np.isfinite(S).sum() > 0.7 * S.size
    assert np.nanmax(S) - np.nanmin(S) < 1e-6
    assert np.nanmax(S) == pytest.approx(1.0, abs=1e-6)


def test_z_translation_spares_the_epipole(figure4: ModuleType):
    S = map_of(figure4, figure4.MOTIONS["z translation"])
    here = figure4.view(np.eye(4), width=WIDTH, paint=waves).image
    u, v = pixels(figure4)
    centre = (u == 0) & (v == 0)
    slope = np.hypot(*np.gradient(here))
    assert slope[centre] > 10.0  # grey/px: S = 1 is no matter of a flat spot
    assert S[centre] == pytest.approx(1.0, abs=1e-9)
    radius = np.hypot(u, v)
    near, far = (radius > 0) & (radius < 6), radius > 60
    assert np.nanmin(S[near]) > 0.99
    assert np.nanmin(S[far]) < 0.6


def test_z_translation_sees_the_radial_gradient_only(figure4: ModuleType):
    T_th = figure4.MOTIONS["z translation"]
    S = map_of(figure4, T_th)
    u, v = pixels(figure4)
    camera, _, _ = figure4.camera_of(WIDTH)
    # the pixel is on the wall at (x, y), wherever the camera has moved
    g_x, g_y = gradient_of_waves(u * figure4.DISTANCE / camera.fx, v * figure4.DISTANCE / camera.fy)
    inside = np.isfinite(S)
    radial = ((g_x * u + g_y * v) ** 2)[inside]  # (g · r̂)² r²
    tangential = ((g_y * u - g_x * v) ** 2)[inside]
    assert np.corrcoef(excess(S[inside]), radial)[0, 1] > 0.99
    assert np.corrcoef(excess(S[inside]), tangential)[0, 1] < 0.5


@pytest.mark.parametrize("paint", [waves, turned])
def test_x_translation_follows_its_formula(figure4: ModuleType, paint):
    T_th = figure4.MOTIONS["x translation"]
    S = map_of(figure4, T_th, paint)
    target = figure4.view(T_th, width=WIDTH, paint=paint).image.astype(np.float64)
    u, v = pixels(figure4)
    camera, _, _ = figure4.camera_of(WIDTH)
    inside = np.isfinite(S)
    t_x, D = T_th[0, 3], 1.0 / figure4.DISTANCE
    g_x = bilinear(
        np.gradient(target, axis=1),
        (u + camera.cx + camera.fx * t_x * D)[inside],
        (v + camera.cy)[inside],
    )
    # Z' D = 1: moving along x changes no depth
    share = (camera.fx * g_x * t_x) ** 2 * figure4.SIGMA_D**2 / (2.0 * figure4.SIGMA_I**2)
    assert inside.sum() > 0.8 * S.size
    np.testing.assert_allclose(excess(S[inside]), share, rtol=1e-4, atol=1e-5)
    assert share.max() > 1.0


def test_x_translation_does_not_see_gradients_in_y(figure4: ModuleType):
    def stripes(x: Map, y: Map) -> Map:
        return 128.0 + 60.0 * np.sin(20.0 * x + 0.5)

    def stripes_turned(x: Map, y: Map) -> Map:
        return stripes(-y, x)

    along_x, along_y = (figure4.MOTIONS["x translation"], se3_exp([0.0, 0.2, 0.0, 0.0, 0.0, 0.0]))
    for dark, light in (
        (map_of(figure4, along_x, stripes), map_of(figure4, along_x, stripes_turned)),
        (map_of(figure4, along_y, stripes_turned), map_of(figure4, along_y, stripes)),
    ):
        assert np.nanmin(dark) < 0.5
        assert np.nanmin(light) == pytest.approx(1.0, abs=1e-6)


def test_normalised_residuals_are_standard_normal(figure4: ModuleType):
    here = figure4.view(np.eye(4), width=321)
    for name, spread in (("rotation", 1.0), ("z translation", 1.5), ("x translation", 2.5)):
        T_th = figure4.MOTIONS[name]
        before, after = figure4.residuals(here, figure4.view(T_th, width=321), T_th)
        assert before.std() > spread - 0.1
        assert after.std() == pytest.approx(1.0, abs=0.1)


def test_figure_is_shipped_and_shown():
    assert 0 < (ROOT / "docs/images/figure4.png").stat().st_size < MAX_FIGURE_BYTES
    assert "../images/figure4.png" in (ROOT / "docs/theory/figure4.md").read_text(encoding="utf-8")
