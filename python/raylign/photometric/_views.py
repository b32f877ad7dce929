"""What images show where patches are expected: the residuals again, in NumPy, for pictures."""

from typing import Any

import numpy as np

from raylign import geometry
from raylign._core import PatchWarp
from raylign._typing import F32, F64, AnyArray
from raylign.image import BSplineImage

_LEAST_DEPTH = 1e-9


def view_values(result: Any, edges: AnyArray, *, start: bool = False) -> F64:
    """(len(edges), n) grey values in the brightness of the patch; NaN outside of the image.

    At the start, too, with the brightness that was found: the difference is motion.
    """
    core, problem, options = result._core, result.problem, result.options
    T_cw = problem.T_cw if start else core.T_cw
    points = problem.points if start else core.points
    image, point = core.edge_image[edges], core.edge_point[edges]
    host = core.hosts[point]
    offsets = options.pattern.offsets
    values = np.full((len(edges), len(offsets)), np.nan)
    for j in np.unique(image):
        mine = np.flatnonzero(image == j)
        uv, z = problem.project(j, T_cw=T_cw, points=points[point[mine]])
        A = _warps(result, T_cw, points[point[mine]], j, point[mine], host[mine])
        at = uv[:, None] + np.einsum("eij,nj->eni", A, offsets)
        at[z <= _LEAST_DEPTH] = np.nan
        pixels = _smoothed(problem.image(j), float(core.presmooth))
        values[mine] = BSplineImage(pixels).sample(at)[0]
    gain, offset = _edge_brightness(core, edges)
    return np.asarray(gain[:, None] * values + offset[:, None])


def _smoothed(image: F32, sigma: float) -> F32:
    """Gaussian blur as before a solve."""
    if sigma <= 0.0:
        return image
    import cv2

    size = 2 * int(np.ceil(4.0 * sigma)) + 1
    blurred = cv2.GaussianBlur(image, (size, size), sigma, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(blurred, np.float32)


def _edge_brightness(core: Any, edges: AnyArray) -> tuple[F64, F64]:
    """Gain and offset (len(edges),) from an image to the brightness of the patch."""
    image, host = core.edge_image[edges], core.hosts[core.edge_point[edges]]
    own = np.where((host >= 0)[:, None], core.brightness[host], 0.0)
    gain = np.exp(core.brightness[image, 0] - own[:, 0])
    return gain, np.exp(-own[:, 0]) * (core.brightness[image, 1] - own[:, 1])


def residual_scales(result: Any, edges: AnyArray) -> F64:
    """(len(edges),) what differences are multiplied with for one variance at every gain."""
    ratio = float(result._core.noise_ratio)
    gain, _ = _edge_brightness(result._core, edges)
    return np.asarray(np.sqrt((1.0 + ratio) / (1.0 + ratio * gain**2)))


def counted(result: Any, edges: AnyArray) -> AnyArray:
    """(len(edges), n) bool: pixels between the limits of saturation at the result."""
    visibility = result.options.visibility
    shown = view_values(result, edges)
    gain, offset = _edge_brightness(result._core, edges)
    raw = (shown - offset[:, None]) / gain[:, None]
    return np.asarray((raw >= visibility.min_grey) & (raw <= visibility.max_grey))


def _warps(result: Any, T_cw: F64, points: F64, j: int, index: AnyArray, host: AnyArray) -> F64:
    """(n, 2, 2) from px of the host to px of image j: identity where there is no host."""
    A = np.tile(np.eye(2), (len(points), 1, 1))
    warp = result.options.warp
    if warp is PatchWarp.NONE:
        return A
    normals = result._core.normals[index]
    for h in np.unique(host[(host >= 0) & (host != j)]):
        rows = np.flatnonzero(host == h)
        n = np.tile([0.0, 0.0, -1.0], (len(rows), 1))
        if warp is not PatchWarp.DEPTH:
            known = np.isfinite(normals[rows]).all(axis=1)
            n[known] = normals[rows[known]]
        A[rows] = plane_warps(result.problem, T_cw, points[rows], int(h), int(j), n)
    return A


def plane_warps(problem: Any, T_cw: F64, points: F64, h: int, j: int, normals: F64) -> F64:
    """(n, 2, 2) derivative of the pixel in image j by the pixel in h, on planes with `normals`."""
    host, target = problem.camera(h), problem.camera(j)
    T_jh = T_cw[j] @ geometry.se3_inverse(T_cw[h])
    p_h = points @ T_cw[h, :3, :3].T + T_cw[h, :3, 3]
    p_j = points @ T_cw[j, :3, :3].T + T_cw[j, :3, 3]
    x, y, z = p_j.T
    P = np.zeros((len(points), 2, 3))
    P[:, 0, 0], P[:, 0, 2] = target.fx / z, -target.fx * x / z**2
    P[:, 1, 1], P[:, 1, 2] = target.fy / z, -target.fy * y / z**2
    PR = P @ T_jh[:3, :3]
    r = p_h / p_h[:, 2:]
    along = np.sum(normals * r, axis=1)
    A = np.empty((len(points), 2, 2))
    for i, f in enumerate((host.fx, host.fy)):
        step = np.eye(3)[i] / f - r * (normals[:, i] / (f * along))[:, None]
        A[:, :, i] = np.einsum("nij,nj->ni", PR, step) * p_h[:, 2:]
    return A
