"""A rendered room for photometric_questions.py: images, points, starts.

Five cameras of 400 x 300 px; the middle one is the host of all patches. Geometry and grey values
are exact until noise of sigma = 2 is added and they are rounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from raylign import synthetic
from raylign.bundle import BundleConfig
from raylign.camera import PinholeCamera
from raylign.geometry import se3_exp, se3_inverse
from raylign.photometric import (
    CovarianceScope,
    PhotometricOptions,
    PhotometricResult,
    Problem,
    adjust,
)

NUM_CAMERAS = 5
HOST = 2
HELD = (0, HOST)
WIDTH, HEIGHT, FOCAL = 400, 300, 250.0
CAMERA = PinholeCamera(FOCAL, FOCAL, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
EXTENT = 0.2  # m, of the cameras to either side
SIGMA = 2.0  # grey levels
CELL = 14  # px: one point each
CONFIG = BundleConfig(gauge="free", constant_cameras=list(HELD))


@dataclass(frozen=True)
class View:
    """Exact images (M of (H, W)), poses and points, and the normals at the points (host frame)."""

    irradiance: tuple[np.ndarray, ...]
    T_cw: np.ndarray
    host_uv: np.ndarray
    depth: np.ndarray  # of the points in the host
    normals: np.ndarray

    @property
    def points(self) -> np.ndarray:
        return back_project(self.T_cw, self.host_uv, self.depth)


def back_project(T_cw: np.ndarray, host_uv: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """(N, 3) world points at depths on rays of the host."""
    rays = (host_uv - [CAMERA.cx, CAMERA.cy]) / FOCAL
    p_h = np.column_stack([rays, np.ones(len(rays))]) * depth[:, None]
    T_wh = se3_inverse(T_cw[HOST])
    return p_h @ T_wh[:3, :3].T + T_wh[:3, 3]


def look(scene: synthetic.Scene, T_cw: np.ndarray) -> View:
    options = synthetic.RenderOptions(antialiasing="none")
    frames = [
        synthetic.render(scene, CAMERA, T, width=WIDTH, height=HEIGHT, options=options)
        for T in T_cw
    ]
    host = frames[HOST]
    gv, gu = np.gradient(host.irradiance)
    steepness = np.hypot(gu, gv)
    flat = np.ones((HEIGHT, WIDTH), bool)
    for axis in (0, 1):
        for step in (-6, 6):
            flat &= np.roll(host.face, step, axis) == host.face
    steepness[~flat] = 0.0
    margin = 20
    uv = []
    for v in range(margin, HEIGHT - margin - CELL, CELL):
        for u in range(margin, WIDTH - margin - CELL, CELL):
            cell = steepness[v + 3 : v + CELL - 3, u + 3 : u + CELL - 3]
            if cell.max() > 0.0:
                at_v, at_u = np.unravel_index(cell.argmax(), cell.shape)
                uv.append((u + 3 + at_u, v + 3 + at_v))
    at = np.array(uv)
    return View(
        tuple(f.irradiance for f in frames),
        T_cw,
        at.astype(np.float64),
        host.depth[at[:, 1], at[:, 0]],
        host.normal[at[:, 1], at[:, 0]],
    )


def room() -> View:
    T_wc = [
        synthetic.look_at(
            EXTENT * np.array([s, 0.4 * np.sin(3 * s), 0.3 * np.cos(3 * s)]), [0, 0, 3]
        )
        for s in np.linspace(-1.0, 1.0, NUM_CAMERAS)
    ]
    return look(synthetic.room(seed=1), se3_inverse(np.array(T_wc)))


def expose(view: View, seed: int) -> list[np.ndarray]:
    options = synthetic.SensorOptions(read_noise=SIGMA)
    return [
        synthetic.expose(image, options=options, seed=seed, index=j)
        for j, image in enumerate(view.irradiance)
    ]


def start(view: View, px: float, seed: int, outliers: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """(T_cw, depth): cameras that are free turned and moved, depths stretched, px off in median."""
    random = np.random.default_rng([seed, 7])
    xi = random.normal(size=(NUM_CAMERAS, 6)) * np.repeat([0.02, 0.01], 3)
    xi[list(HELD)] = 0.0
    stretch = 0.03 * random.normal(size=len(view.depth))

    def moved(factor: float) -> tuple[np.ndarray, np.ndarray]:
        return se3_exp(factor * xi) @ view.T_cw, view.depth * np.exp(factor * stretch)

    true = project(view.T_cw, view.points)
    factor = 1.0
    for _ in range(20):
        T_cw, depth = moved(factor)
        shift = project(T_cw, back_project(T_cw, view.host_uv, depth)) - true
        free = [j for j in range(NUM_CAMERAS) if j not in HELD]
        factor *= px / np.median(np.linalg.norm(shift[:, free], axis=-1))
    T_cw, depth = moved(factor)
    wrong = random.random(len(depth)) < outliers
    depth[wrong] *= np.where(random.random(wrong.sum()) < 0.5, 0.7, 1.3)
    return T_cw, depth


def project(T_cw: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N, M, 2) px."""
    q = np.einsum("mij,nj->nmi", T_cw[:, :3, :3], points) + T_cw[:, :3, 3]
    return FOCAL * q[..., :2] / q[..., 2:] + [CAMERA.cx, CAMERA.cy]


def center_rms(view: View, T_cw: np.ndarray) -> float:
    """Root mean square distance of the free cameras to their true centres, mm."""
    error = np.linalg.norm((se3_inverse(T_cw) - se3_inverse(view.T_cw))[:, :3, 3], axis=1)
    free = [j for j in range(NUM_CAMERAS) if j not in HELD]
    return 1e3 * float(np.sqrt(np.mean(error[free] ** 2)))


def refine(
    view: View,
    images: Sequence[np.ndarray],
    T_cw: np.ndarray,
    depth: np.ndarray,
    *,
    config: BundleConfig = CONFIG,
    **options,
) -> PhotometricResult:
    problem = Problem(
        images,
        CAMERA,
        T_cw,
        back_project(T_cw, view.host_uv, depth),
        host=np.full(len(depth), HOST, np.int32),
        host_uv=view.host_uv,
        normals=view.normals,
    )
    chosen = {"force": True, "covariance": CovarianceScope.NONE, **options}
    return adjust(problem, config=config, options=PhotometricOptions(**chosen))


def rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
