"""The tests' own Cramér-Rao bound, on which the accuracy tests rest."""

import numpy as np
import pytest

import photometric_bound
import photometric_scenes as scenes
from raylign.geometry import se3_exp

TRUTH = scenes.make(scenes.Path.LARGE, num_points=70)


def pixel(T_cw: np.ndarray, rho: float, p: int, j: int, offset=(0.0, 0.0)) -> np.ndarray:
    """Where the host pixel of p shows in j, at inverse depth rho or, beside it, on p's plane."""
    host, camera = TRUTH.hosts[p], scenes.CAMERA
    f, c = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    ray = np.append((TRUTH.host_uv[p] - c) / f, 1.0)
    beside = np.append((TRUTH.host_uv[p] + offset - c) / f, 1.0)
    normal = TRUTH.normals[p]
    q_host = beside * (normal @ ray) / (normal @ beside) / rho
    q = T_cw[j] @ np.linalg.inv(T_cw[host]) @ np.append(q_host, 1.0)
    return f * q[:2] / q[2] + c


@pytest.mark.parametrize(("p", "j"), [(3, 5), (40, 0), (61, 2)])
def test_geometry_is_the_derivative_of_the_projection(p: int, j: int):
    host = TRUTH.hosts[p]
    rho = 1.0 / (TRUTH.T_cw[host] @ np.append(TRUTH.points[p], 1.0))[2]
    A, du_dxi, du_dxi_host, du_drho, uv = photometric_bound.geometry(TRUTH, p, j)
    np.testing.assert_allclose(uv, pixel(TRUTH.T_cw, rho, p, j), atol=1e-9)

    def difference(h: float, at) -> np.ndarray:
        return (at(h) - at(-h)) / (2 * h)

    def moved(image: int, xi: np.ndarray) -> np.ndarray:
        T_cw = TRUTH.T_cw.copy()
        T_cw[image] = se3_exp(xi) @ T_cw[image]
        return pixel(T_cw, rho, p, j)

    for k, e in enumerate(np.eye(6)):
        numeric = difference(1e-6, lambda h, e=e: moved(j, h * e))
        np.testing.assert_allclose(du_dxi[:, k], numeric, atol=1e-6)
        numeric = difference(1e-6, lambda h, e=e: moved(host, h * e))
        np.testing.assert_allclose(du_dxi_host[:, k], numeric, atol=1e-6)
    numeric = difference(1e-6, lambda h: pixel(TRUTH.T_cw, rho + h, p, j))
    np.testing.assert_allclose(du_drho, numeric, atol=1e-5)
    for i, e in enumerate(np.eye(2)):
        numeric = difference(1e-4, lambda h, e=e: pixel(TRUTH.T_cw, rho, p, j, h * e))
        np.testing.assert_allclose(A[:, i], numeric, atol=1e-7)


def test_patches_show_the_same_surface_in_every_view():
    """What is read along the warp is the host's patch: to the spline's error on 4 px waves."""
    errors = []
    for j in range(scenes.NUM_CAMERAS):
        spline = photometric_bound.spline_filter(TRUTH.irradiance[j], order=3, mode="mirror")
        for p in np.flatnonzero(TRUTH.seen[:, j]):
            A, *_, uv = photometric_bound.geometry(TRUTH, p, j)
            at = uv + photometric_bound.OFFSETS @ A.T
            shown, _ = photometric_bound.sample(spline, at)
            u, v = (TRUTH.host_uv[p] + photometric_bound.OFFSETS).astype(int).T
            errors.append(shown - TRUTH.irradiance[TRUTH.hosts[p]][v, u])
    assert np.sqrt(np.mean(np.square(errors))) < 0.5
    assert np.median(np.abs(errors)) < 0.1


def test_bound_scales_with_the_noise_and_grows_with_what_is_unknown():
    known = photometric_bound.bound(TRUTH, 2.0, noisy_patches=False).centre_rms
    plain = photometric_bound.bound(TRUTH, 2.0).centre_rms
    with_brightness = photometric_bound.bound(TRUTH, 2.0, brightness=True).centre_rms
    assert known < plain < with_brightness < 1.5 * known
    assert photometric_bound.bound(TRUTH, 4.0).centre_rms == pytest.approx(2.0 * plain)
