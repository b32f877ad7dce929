"""Points for a photometric problem from images with depth."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from raylign._typing import F64, I32, AnyArray, Bool
from raylign.camera import PinholeCamera
from raylign.depth import DepthModel, inverse_depth
from raylign.errors import OptionsError, ShapeError
from raylign.image import ColorOrder, gradient_image
from raylign.photometric._images import Camera

_BORDER = 6  # px: the patch and what its interpolation reads
_RADIUS = 4  # px: of the window that has depth without a step, and gives the normal
_MAX_STEP = 0.03  # between neighbours, of the depth: more is a depth edge
_MAX_BEND = 2.5e-3  # RMS distance from a plane, of the inverse depth, …
_MAX_NOISE = 2.0  # … or this many times what is usual in the image
_MIN_GRADIENT = 6.0  # grey levels per px


@dataclass(frozen=True)
class SelectedPoints:
    """Points with where they come from; see `Problem`."""

    points: F64
    host: I32
    host_uv: F64
    normals: F64
    depth_sigma: F64 | None


def select_points(
    images: Sequence[AnyArray],
    depths: Sequence[AnyArray],
    cameras: list[Camera],
    T_cw: F64,
    *,
    n_points: int,
    depth_scale: float,
    model: DepthModel | None,
    color_order: ColorOrder,
) -> SelectedPoints:
    """Choose about n_points, the same number from every image.

    Raises:
        OptionsError: there is no texture with depth, or a camera is distorted.
        ShapeError: an image and its depth differ in size.
    """
    if n_points < 1:
        raise OptionsError(f"n_points must be >= 1, got {n_points}")
    parts = []
    for i, (image, depth) in enumerate(zip(images, depths, strict=True)):
        camera = cameras[i if len(cameras) > 1 else 0]
        if not isinstance(camera, PinholeCamera):
            raise OptionsError("from_depth needs rectified images: K without distortion")
        share = n_points * (i + 1) // len(images) - n_points * i // len(images)
        Z, sigma = _metres(depth, depth_scale, model)
        if image.shape[:2] != Z.shape:
            raise ShapeError(f"images[{i}] is {image.shape}, depths[{i}] is {Z.shape}")
        gradient = gradient_image(image, color_order=color_order)[:, :, 1:3]
        strength = np.hypot(gradient[:, :, 0], gradient[:, :, 1])
        planes = _fit_planes(Z)
        uv = _spread(np.where(_usable(Z, planes), strength, 0.0), share)
        parts.append(_points(i, uv, Z, sigma, planes, camera, T_cw[i]))
    if not any(len(part.host) for part in parts):
        raise OptionsError(
            f"no image has a gradient of {_MIN_GRADIENT:g} grey levels per px where it has depth "
            "of a smooth surface"
        )
    return _join(parts)


def _metres(depth: AnyArray, scale: float, model: DepthModel | None) -> tuple[F64, F64 | None]:
    """Depth, NaN where there is none, and its standard deviation where a model is given."""
    array = np.asarray(depth)
    if array.ndim != 2:
        raise ShapeError(f"a depth must be (H, W), got {array.shape}")
    if model is not None:
        given = np.ascontiguousarray(
            array if array.dtype == np.uint16 else array.astype(np.float32)
        )
        D, V = inverse_depth(given, model=model, depth_scale=scale)
        Z = np.divide(1.0, D, out=np.full(D.shape, np.nan), where=D > 0)
        return Z, Z * Z * np.sqrt(V.astype(np.float64))
    Z = array.astype(np.float64) / (scale if array.dtype == np.uint16 else 1.0)
    Z[~(np.isfinite(Z) & (Z > 0.0))] = np.nan
    return Z, None


@dataclass(frozen=True)
class _Planes:
    """The plane through the depths around each pixel: 1 / Z ≈ D + D_u du + D_v dv; (H, W) each.

    On a plane 1 / Z is linear in the pixel, and a sensor's noise of it nearly the same everywhere.
    """

    D: F64
    D_u: F64
    D_v: F64
    bend: F64  # RMS distance from the plane


def _fit_planes(Z: F64) -> _Planes:
    """Least squares over (2 r + 1)² pixels, by sums along columns, then along rows."""
    k = np.arange(-_RADIUS, _RADIUS + 1)
    D = np.nan_to_num(1.0 / Z)  # around pixels without depth nothing is used

    def window(values: F64, along: F64, axis: int) -> F64:
        return np.asarray(sum(w * np.roll(values, -j, axis) for j, w in zip(k, along, strict=True)))

    one = np.ones(len(k))
    columns = window(D, one, 0)
    number, slope = float(len(k) ** 2), float(len(k) * np.sum(k * k))
    mean = window(columns, one, 1) / number
    D_u = window(columns, k.astype(float), 1) / slope
    D_v = window(window(D, k.astype(float), 0), one, 1) / slope
    power = window(window(D * D, one, 0), one, 1) / number
    bend = power - mean * mean - (D_u * D_u + D_v * D_v) * slope / number
    return _Planes(mean, D_u, D_v, np.sqrt(np.maximum(bend, 0.0)))


def _usable(Z: F64, planes: _Planes) -> Bool:
    """Depth all around, on a plane up to noise, without a step; not at the border.

    A patch across a corner changes its shape from view to view, which no warp follows.
    """
    usable = np.zeros(Z.shape, bool)
    if min(Z.shape) <= 2 * _BORDER:
        return usable
    step = np.isnan(Z)
    for axis in (0, 1):
        with np.errstate(invalid="ignore"):
            step |= np.abs(np.roll(Z, 1, axis) - Z) > _MAX_STEP * Z
    for axis in (0, 1):  # wider by the radius
        step = np.logical_or.reduce([np.roll(step, k, axis) for k in range(-_RADIUS, _RADIUS + 1)])
    inner = slice(_BORDER, -_BORDER)
    usable[inner, inner] = ~step[inner, inner]
    if usable.any():
        noise = float(np.median(planes.bend[usable]))
        usable &= planes.bend <= np.maximum(_MAX_BEND * planes.D, _MAX_NOISE * noise)
    return usable


def _spread(strength: AnyArray, wanted: int) -> AnyArray:
    """(n, 2) px of the strongest pixel of each cell: of a coarse grid, then of one twice as fine.

    The coarse grid has half as many cells as points are wanted, so that poor regions get some; the
    fine grid fills up where texture is rich.
    """
    if wanted == 0:
        return np.zeros((0, 2), np.int64)
    cell = max(4, int(np.sqrt(2.0 * strength.size / wanted)))
    coarse = _cell_maxima(strength, cell)
    fine = _cell_maxima(strength, max(3, cell // 2))
    order = np.argsort(-strength[fine[:, 1], fine[:, 0]], kind="stable")
    merged = np.concatenate([coarse, fine[order]])
    _, first = np.unique(merged @ [1, strength.shape[1]], return_index=True)
    return np.asarray(merged[np.sort(first)][:wanted])


def _cell_maxima(strength: AnyArray, cell: int) -> AnyArray:
    """(n, 2) px of the maximum of each cell that has enough gradient, row by row."""
    rows, columns = strength.shape[0] // cell, strength.shape[1] // cell
    blocks = strength[: rows * cell, : columns * cell].reshape(rows, cell, columns, cell)
    flat = blocks.transpose(0, 2, 1, 3).reshape(rows, columns, cell * cell)
    best = flat.argmax(axis=2)
    v = np.arange(rows)[:, None] * cell + best // cell
    u = np.arange(columns)[None] * cell + best % cell
    strong = flat.max(axis=2) >= _MIN_GRADIENT
    return np.stack([u[strong], v[strong]], axis=1)


def _points(
    i: int,
    uv: AnyArray,
    Z: F64,
    sigma: F64 | None,
    planes: _Planes,
    camera: PinholeCamera,
    T_cw: F64,
) -> SelectedPoints:
    """The pixels uv of image i as points in the world."""
    u, v = uv[:, 0], uv[:, 1]
    p_c = _unproject(camera, u, v, Z)
    return SelectedPoints(
        (p_c - T_cw[:3, 3]) @ T_cw[:3, :3],
        np.full(len(uv), i, np.int32),
        uv.astype(np.float64),
        _normals(camera, u, v, planes),
        None if sigma is None else sigma[v, u],
    )


def _join(parts: list[SelectedPoints]) -> SelectedPoints:
    sigmas = [part.depth_sigma for part in parts if part.depth_sigma is not None]
    return SelectedPoints(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.host for part in parts]),
        np.concatenate([part.host_uv for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate(sigmas) if sigmas else None,
    )


def _unproject(camera: PinholeCamera, u: AnyArray, v: AnyArray, Z: F64) -> F64:
    z = Z[v, u]
    return np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z], axis=1)


def _normals(camera: PinholeCamera, u: AnyArray, v: AnyArray, planes: _Planes) -> F64:
    """Unit, camera frame, towards the camera."""
    D_u, D_v = planes.D_u[v, u], planes.D_v[v, u]
    at_axis = planes.D[v, u] - D_u * (u - camera.cx) - D_v * (v - camera.cy)
    n = -np.stack([camera.fx * D_u, camera.fy * D_v, at_axis], axis=1)
    return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))
