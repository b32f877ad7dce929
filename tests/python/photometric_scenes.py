"""Rendered rooms with points on their walls, for the tests and benchmarks of raylign.photometric.

Seven cameras of 480x360 px, f = 300 px, look into a room 1.5 to 4 m away. Points lie on pixel
centres of their hosts, where the grey values change most; their positions and normals are exact by
construction, and the noise is a draw of its own for every seed.
"""

from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache

import numpy as np

from raylign import photometric, synthetic
from raylign.bundle import BundleConfig
from raylign.camera import PinholeCamera
from raylign.geometry import se3_exp, se3_inverse

WIDTH, HEIGHT = 480, 360
CAMERA = PinholeCamera(300.0, 300.0, 239.5, 179.5)
NUM_CAMERAS = 7
NUM_POINTS = 760
MARGIN = 6.0  # px between a projection and the border for a view to count as seen
SATURATING = 1.4  # exposure at which a twentieth of the pixels are white
BORDER = int(MARGIN) + 6  # px of a host without points
APART = 7  # px between points, so that no two read the same pixels
BOARD_FACE = 6  # the room has faces 0 to 5


class Path(Enum):
    """How far the cameras are apart: +- extent m sideways, +- roll degrees."""

    SMALL = (0.15, 0.0)
    MEDIUM = (0.3, 2.0)
    LARGE = (0.5, 6.0)

    @property
    def extent(self) -> float:
        return self.value[0]

    def poses(self) -> np.ndarray:
        """T_cw (M, 4, 4); all cameras look at about the same place."""
        extent, roll = self.value
        T_wc = []
        for s in np.linspace(-1.0, 1.0, NUM_CAMERAS):
            eye = extent * np.array([s, 0.35 * np.sin(2.5 * s + 0.4), 0.3 * np.cos(3.0 * s)])
            target = [0.25 * s * extent, 0.05, 2.9]
            T_wc.append(synthetic.look_at(eye, target, roll_deg=roll * s))
        return se3_inverse(np.array(T_wc))


@dataclass(frozen=True)
class Truth:
    """M images, N points; what `irradiance` shows is exact.

    Attributes:
        irradiance: M x (H, W) float64 grey values without noise.
        T_cw: (M, 4, 4).
        points: (N, 3) world, m.
        hosts: (N,) image that each patch is read from.
        host_uv: (N, 2) px, whole numbers.
        normals: (N, 3) unit, host frame, towards the camera.
        seen: (N, M) bool: inside the image and not hidden.
    """

    irradiance: tuple[np.ndarray, ...]
    T_cw: np.ndarray
    points: np.ndarray
    hosts: np.ndarray
    host_uv: np.ndarray
    normals: np.ndarray
    seen: np.ndarray

    @property
    def centres(self) -> np.ndarray:
        """(M, 3) camera centres, world, m."""
        return se3_inverse(self.T_cw)[:, :3, 3]


@dataclass(frozen=True)
class Start:
    """Where a solve starts: T_cw (M, 4, 4), points (N, 3)."""

    T_cw: np.ndarray
    points: np.ndarray


@lru_cache(maxsize=16)
def make(
    path: Path = Path.SMALL, *, seed: int = 0, num_points: int = NUM_POINTS, board: bool = False
) -> Truth:
    """Render a room; `board`: somebody carries a plate past that hides a tenth of each view."""
    T_cw = path.poses()
    frames = []
    for j, T in enumerate(T_cw):
        scene = synthetic.room(seed=seed)
        if board:
            offset = (0.9 * (j / (NUM_CAMERAS - 1) - 0.5), 0.25 * (-1) ** j)
            scene += synthetic.board(seed=seed, distance=1.35, size=(0.66, 0.52), offset=offset)
        frames.append(_render(scene, T))
    hosts, host_uv, normals, points = _choose(frames, T_cw, num_points)
    seen = _visible(frames, T_cw, points)
    kept = seen.sum(axis=1) >= 3
    return Truth(
        tuple(f.irradiance for f in frames),
        T_cw,
        points[kept],
        hosts[kept],
        host_uv[kept],
        normals[kept],
        seen[kept],
    )


def _render(scene: synthetic.Scene, T_cw: np.ndarray) -> synthetic.Frame:
    # Without anti-aliasing a place on a wall has the same grey value in every view. The shortest
    # wave of the texture is 4 px or more where a wall is seen from the front.
    options = synthetic.RenderOptions(antialiasing="none")
    return synthetic.render(scene, CAMERA, T_cw, width=WIDTH, height=HEIGHT, options=options)


def _choose(frames: list[synthetic.Frame], T_cw: np.ndarray, num_points: int):
    """Points of all hosts. No two share pixels: their noise would not be independent."""
    hosts, host_uv, normals, points = [], [], [], np.zeros((0, 3))
    for h, part in enumerate(np.array_split(np.arange(num_points), NUM_CAMERAS)):
        score = _steepness(frames[h])
        taken = np.rint(project(T_cw[h : h + 1], points)[0][:, 0]).astype(int)
        for u, v in taken:
            _block(score, u, v)
        uv = _best_pixels(score, len(part))
        depth = np.array([frames[h].depth[v, u] for u, v in uv])
        at = np.full(len(uv), h, np.int32)
        points = np.concatenate([points, back_project(T_cw, at, uv.astype(float), depth)])
        hosts.append(at)
        host_uv.append(uv.astype(np.float64))
        normals.append(frames[h].normal[uv[:, 1], uv[:, 0]])
    return np.concatenate(hosts), np.concatenate(host_uv), np.concatenate(normals), points


def _steepness(frame: synthetic.Frame) -> np.ndarray:
    """Size of the gradient (H, W); zero by the image border and the edges of the room."""
    gv, gu = np.gradient(frame.irradiance)
    score = np.hypot(gu, gv)
    reach = 5
    flat = frame.face < BOARD_FACE
    for dv in (-reach, 0, reach):
        for du in (-reach, 0, reach):
            flat &= np.roll(frame.face, (dv, du), axis=(0, 1)) == frame.face
    score[~flat] = 0.0
    score[:BORDER], score[-BORDER:], score[:, :BORDER], score[:, -BORDER:] = 0.0, 0.0, 0.0, 0.0
    return score


def _block(score: np.ndarray, u: int, v: int) -> None:
    rows = slice(max(v - APART, 0), max(v + APART + 1, 0))
    score[rows, max(u - APART, 0) : max(u + APART + 1, 0)] = 0.0


def _best_pixels(score: np.ndarray, count: int) -> np.ndarray:
    """(count, 2) pixels (u, v): the best of each cell of a grid."""
    side = np.sqrt((WIDTH - 2 * BORDER) * (HEIGHT - 2 * BORDER) / (1.25 * count))
    best = []
    for v0 in np.arange(BORDER, HEIGHT - BORDER - side / 2, side):
        for u0 in np.arange(BORDER, WIDTH - BORDER - side / 2, side):
            cell = score[int(v0) : int(v0 + side), int(u0) : int(u0 + side)]
            v, u = np.unravel_index(cell.argmax(), cell.shape)
            best.append((cell[v, u], int(u0) + u, int(v0) + v))
            _block(score, int(u0) + u, int(v0) + v)
    best = [item for item in best if item[0] > 0.0]
    best.sort(key=lambda item: -item[0])
    return np.array([(u, v) for _, u, v in best[:count]])


def back_project(
    T_cw: np.ndarray, hosts: np.ndarray, host_uv: np.ndarray, depth: np.ndarray
) -> np.ndarray:
    """Points (N, 3) in the world, at `depth` (N,) on the rays of their hosts."""
    rays = np.column_stack(
        [
            (host_uv[:, 0] - CAMERA.cx) / CAMERA.fx,
            (host_uv[:, 1] - CAMERA.cy) / CAMERA.fy,
            np.ones(len(hosts)),
        ]
    )
    T_wc = se3_inverse(T_cw)[hosts]
    local = rays * depth[:, None]
    return np.einsum("nij,nj->ni", T_wc[:, :3, :3], local) + T_wc[:, :3, 3]


def project(T_cw: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (N, M, 2) and depths (N, M) of all points in all cameras."""
    q = np.einsum("mij,nj->nmi", T_cw[:, :3, :3], points) + T_cw[None, :, :3, 3]
    z = q[..., 2]
    u = CAMERA.fx * q[..., 0] / z + CAMERA.cx
    v = CAMERA.fy * q[..., 1] / z + CAMERA.cy
    return np.stack([u, v], axis=-1), z


def _visible(frames: list[synthetic.Frame], T_cw: np.ndarray, points: np.ndarray) -> np.ndarray:
    uv, z = project(T_cw, points)
    inside = (
        (z > 0.1)
        & (uv >= MARGIN).all(axis=-1)
        & (uv <= np.array([WIDTH, HEIGHT]) - 1.0 - MARGIN).all(axis=-1)
    )
    at = np.clip(np.rint(np.nan_to_num(uv)), 0, [WIDTH - 1, HEIGHT - 1]).astype(int)
    hidden = np.zeros_like(inside)
    for j, frame in enumerate(frames):
        hidden[:, j] = frame.depth[at[:, j, 1], at[:, j, 0]] < 0.9 * z[:, j]
    return inside & ~hidden


def expose(
    truth: Truth,
    *,
    sigma: float,
    seed: int = 0,
    gain: np.ndarray | None = None,
    bias: np.ndarray | None = None,
    exposure: float = 1.0,
    eight_bit: bool = True,
) -> list[np.ndarray]:
    """Images as a sensor of noise `sigma` takes them: e^gain (exposure · irradiance) + bias."""
    images = []
    for j, irradiance in enumerate(truth.irradiance):
        options = synthetic.SensorOptions(
            read_noise=sigma,
            exposure=exposure,
            gain=0.0 if gain is None else float(gain[j]),
            bias=0.0 if bias is None else float(bias[j]),
            format="uint8" if eight_bit else "float32",
        )
        images.append(synthetic.expose(irradiance, options=options, seed=seed, index=j))
    return images


def white_patches(truth: Truth, *, exposure: float) -> np.ndarray:
    """(N,) bool: half of the 4x4 patch or more is brighter in its host than what counts (250)."""
    reach = np.arange(-2, 2)
    white = []
    for host, (u, v) in zip(truth.hosts, truth.host_uv.astype(int), strict=True):
        patch = truth.irradiance[host][np.ix_(v + reach, u + reach)]
        white.append(np.mean(exposure * patch > 250.0) >= 0.5)
    return np.array(white)


def perturb(
    truth: Truth,
    *,
    degrees: float,
    metres: float,
    depth: float,
    seed: int,
    fixed: tuple[int, ...] = (0, NUM_CAMERAS - 1),
) -> Start:
    """Move the cameras that are not fixed, and the points along the rays of their hosts.

    Every camera turns by `degrees` and moves by `metres` in a direction of its own; depths change
    by a normal draw of `depth` (a share of 1).
    """
    random = np.random.default_rng([seed, 0x51])
    directions = random.normal(size=(NUM_CAMERAS, 2, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    stretch = random.normal(size=len(truth.points))
    xi = np.concatenate([metres * directions[:, 0], np.radians(degrees) * directions[:, 1]], axis=1)
    xi[list(fixed)] = 0.0
    T_cw = se3_exp(xi) @ truth.T_cw
    _, z = project(truth.T_cw, truth.points)
    host_depth = z[np.arange(len(z)), truth.hosts] / np.maximum(1.0 + depth * stretch, 0.2)
    return Start(T_cw, back_project(T_cw, truth.hosts, truth.host_uv, host_depth))


def shift_px(truth: Truth, start: Start) -> float:
    """Median distance in px of the projections from where they belong, hosts left out."""
    before, _ = project(start.T_cw, start.points)
    after, _ = project(truth.T_cw, truth.points)
    counts = truth.seen.copy()
    counts[np.arange(len(counts)), truth.hosts] = False
    return float(np.median(np.linalg.norm(before - after, axis=-1)[counts]))


def shifted(truth: Truth, px: float, *, seed: int) -> Start:
    """A start that is `px` off in the median: angle, way and depth errors in fixed proportion."""
    low, high = 0.0, 1.0
    while shift_px(truth, _scaled(truth, high, seed)) < px:
        high *= 2.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        if shift_px(truth, _scaled(truth, middle, seed)) < px:
            low = middle
        else:
            high = middle
    return _scaled(truth, high, seed)


def _scaled(truth: Truth, factor: float, seed: int) -> Start:
    # 1 degree, 3 cm and 5 % of the depth, which is what T3 of the specification starts from.
    return perturb(truth, degrees=factor, metres=0.03 * factor, depth=0.05 * factor, seed=seed)


def with_wrong_depths(
    truth: Truth, start: Start, *, share: float, error: float, seed: int
) -> tuple[Start, np.ndarray]:
    """The start with a share of the points at depths wrong by +- error; which (N,) bool."""
    random = np.random.default_rng([seed, 0x52])
    wrong = np.zeros(len(truth.points), bool)
    wrong[random.permutation(len(wrong))[: round(share * len(wrong))]] = True
    factor = np.where(random.random(len(wrong)) < 0.5, 1.0 - error, 1.0 + error)
    _, z = project(start.T_cw, start.points)
    host_depth = z[np.arange(len(z)), truth.hosts] * np.where(wrong, factor, 1.0)
    points = back_project(start.T_cw, truth.hosts, truth.host_uv, host_depth)
    return replace(start, points=points), wrong


def centre_errors(truth: Truth, T_cw: np.ndarray) -> np.ndarray:
    """(M,) m between the true and the found camera centres."""
    return np.linalg.norm(se3_inverse(T_cw)[:, :3, 3] - truth.centres, axis=1)


HELD = BundleConfig(gauge="free", constant_cameras=[0, NUM_CAMERAS - 1])


def problem(truth: Truth, images: list[np.ndarray], start: Start, **known) -> photometric.Problem:
    """The start with everything that a front end knows: hosts, their pixels, normals."""
    arguments = {
        "host": truth.hosts,
        "host_uv": truth.host_uv,
        "normals": truth.normals,
        **known,
    }
    return photometric.Problem(images, CAMERA, start.T_cw, start.points, **arguments)


def refine(
    truth: Truth,
    images: list[np.ndarray],
    start: Start,
    *,
    config: BundleConfig = HELD,
    **changes,
) -> photometric.PhotometricResult:
    """`adjust` with the first and the last camera held; `changes`: options."""
    options = photometric.PhotometricOptions(**changes)
    return photometric.adjust(problem(truth, images, start), config=config, options=options)


def centre_rms(truth: Truth, T_cw: np.ndarray) -> float:
    """Root mean square distance to the true centres, m, without those that `HELD` holds."""
    return float(np.sqrt(np.mean(centre_errors(truth, T_cw)[1:-1] ** 2)))


def point_errors_px(truth: Truth, result: photometric.PhotometricResult) -> np.ndarray:
    """(N,) px: median over the views of the distance from the true projections."""
    found, _ = project(result.T_cw, result.points)
    true, _ = project(truth.T_cw, truth.points)
    distance = np.linalg.norm(found - true, axis=-1)
    return np.nanmedian(np.where(truth.seen, distance, np.nan), axis=1)
