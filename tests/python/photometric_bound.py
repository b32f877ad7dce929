"""The Cramér-Rao bound of a rendered scene in plain NumPy: nothing here is shared with raylign.

Unknown are the poses T_cw <- exp(xi) T_cw, one inverse depth per point on the exact ray of its
host, a and b per image, and, because the host's pixels are as noisy as the others, the 16 true grey
values of each patch. Everything else is known, and the gradients are those of noise-free images.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates, spline_filter

import photometric_scenes as scenes

OFFSETS = np.array([(du, dv) for du in range(-2, 2) for dv in range(-2, 2)], np.float64)


@dataclass(frozen=True)
class Bound:
    """Covariances at the bound: of the free poses' xi (F, 6, F, 6) and of their centres."""

    free: list[int]
    covariance: np.ndarray
    centres: np.ndarray

    @property
    def centre_rms(self) -> float:
        """Root mean square over the free cameras of the distance to the true centre, m."""
        return float(np.sqrt(np.mean(np.trace(self.centres, axis1=1, axis2=2))))


def bound(
    truth: scenes.Truth,
    sigma: float,
    *,
    fixed: tuple[int, ...] = (0, scenes.NUM_CAMERAS - 1),
    brightness: bool = False,
    noisy_patches: bool = True,
) -> Bound:
    """`sigma`: noise of one pixel, rounding included."""
    M = len(truth.T_cw)
    width = 8 if brightness else 6
    F = np.zeros((M * width, M * width))
    splines = [spline_filter(image, order=3, mode="mirror") for image in truth.irradiance]
    for p in range(len(truth.points)):
        F += _point_information(truth, splines, p, width, noisy_patches)
    F /= sigma**2
    held = {j * width + k for j in fixed for k in range(6)}
    held |= {k for k in range(6, width)}  # a, b of image 0
    kept = [i for i in range(M * width) if i not in held]
    C = np.zeros_like(F)
    C[np.ix_(kept, kept)] = np.linalg.inv(F[np.ix_(kept, kept)])
    free = [j for j in range(M) if j not in fixed]
    C = C.reshape(M, width, M, width)[np.ix_(free, range(6), free, range(6))]
    centres = []
    for k, j in enumerate(free):
        # C = -R^T t; T <- exp(xi) T moves it by -R^T v at a rotation about the camera itself.
        G = -truth.T_cw[j, :3, :3].T
        centres.append(G @ C[k, :3, k, :3] @ G.T)
    return Bound(free, C, np.array(centres))


def _point_information(truth, splines, p: int, width: int, noisy_patches: bool) -> np.ndarray:
    """(M width, M width) with the inverse depth, and the patch when it is noisy, eliminated."""
    M, host = len(truth.T_cw), truth.hosts[p]
    views = [j for j in np.flatnonzero(truth.seen[p]) if j != host]
    J = np.zeros((len(views), 16, M * width + 1))
    for row, j in enumerate(views):
        A, du_dxi, du_dxi_host, du_drho, uv = geometry(truth, p, j)
        at = uv + OFFSETS @ A.T
        value, slope = sample(splines[j], at)
        J[row, :, j * width : j * width + 6] = slope @ du_dxi
        J[row, :, host * width : host * width + 6] += slope @ du_dxi_host
        J[row, :, -1] = slope @ du_drho
        if width == 8:
            # e^{a_j - a_h} I_j + e^{-a_h} (b_j - b_h) at a = b = 0
            J[row, :, j * width + 6] = value
            J[row, :, j * width + 7] = 1.0
            J[row, :, host * width + 6] -= value
            J[row, :, host * width + 7] -= 1.0
    F = np.einsum("vni,vnj->ij", J, J)
    if noisy_patches:
        total = J.sum(axis=0)
        F -= total.T @ total / (len(views) + 1.0)
    return F[:-1, :-1] - np.outer(F[:-1, -1], F[-1, :-1]) / F[-1, -1]


def geometry(truth: scenes.Truth, p: int, j: int):
    """Warp A (2, 2), d(u, v) / d xi_j, d xi_h (2, 6), d rho (2,), and (u, v) of point p in j."""
    camera, host = scenes.CAMERA, truth.hosts[p]
    f = np.array([camera.fx, camera.fy])
    ray = np.append((truth.host_uv[p] - [camera.cx, camera.cy]) / f, 1.0)
    T = truth.T_cw[j] @ np.linalg.inv(truth.T_cw[host])
    R, t = T[:3, :3], T[:3, 3]
    q_host = truth.T_cw[host][:3, :3] @ truth.points[p] + truth.T_cw[host][:3, 3]
    q = R @ q_host + t
    P = np.array([[f[0], 0.0, -f[0] * q[0] / q[2]], [0.0, f[1], -f[1] * q[1] / q[2]]]) / q[2]
    # A neighbour of the host pixel, on the plane through the point: q_host (1 + da) along its ray.
    n = truth.normals[p]
    on_plane = np.column_stack(
        [q_host[2] / f[i] * (np.eye(3)[i] - ray * n[i] / (n @ ray)) for i in range(2)]
    )
    A = P @ R @ on_plane
    du_dxi = P @ np.hstack([np.eye(3), -_skew(q)])
    du_dxi_host = -P @ R @ np.hstack([np.eye(3), -_skew(q_host)])
    du_drho = -P @ R @ q_host * q_host[2]  # d q_host / d rho = -q_host z
    uv = f * q[:2] / q[2] + [camera.cx, camera.cy]
    return A, du_dxi, du_dxi_host, du_drho, uv


def _skew(x: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def sample(spline: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Value (n,) and gradient (n, 2) of the cubic spline; central differences are exact to h^2."""
    h = 1e-3

    def value(offset: tuple[float, float]) -> np.ndarray:
        u, v = (at + offset).T
        return map_coordinates(spline, [v, u], order=3, mode="mirror", prefilter=False)

    slope = [value((h, 0)) - value((-h, 0)), value((0, h)) - value((0, -h))]
    return value((0, 0)), np.stack(slope, axis=1) / (2 * h)
