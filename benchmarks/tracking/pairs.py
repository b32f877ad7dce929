"""TUM pairs with a published answer: residuals at our pose and at theirs, over one mask."""

import cv2
import numpy as np

from raylign import geometry
from raylign.camera import PinholeCamera
from raylign.depth import inverse_depth
from raylign.tracking import Keyframe, TrackingOptions, align
from tracking import frames

DEPTH_SCALE = 5000.0


class Pair:
    """Two RGB-D frames; xi = [upsilon; omega] warps the first into the second."""

    def __init__(self, host, depth, target, broken, camera, xi, bounds, broken_bounds) -> None:
        self.host, self.depth, self.target, self.broken = host, depth, target, broken
        self.camera = PinholeCamera(*camera)
        self.truth = geometry.se3_exp(np.array(xi))
        self.bounds, self.broken_bounds = bounds, broken_bounds  # mm, degrees


PAIRS = (
    Pair(
        "1305031102.275326", "1305031102.262886", "1305031102.175304", "target",
        (517.3, 516.5, 318.6, 255.3), (-0.0018, 0.0065, 0.0369, -0.0287, -0.0184, -0.0004),
        (0.5, 0.03), (2.0, 0.06),
    ),
    Pair(
        "1341847980.722988", "1341847980.723020", "1341847982.998783", "host",
        (535.4, 539.2, 320.1, 247.6), (0.2979, -0.0106, 0.0452, -0.0041, -0.0993, -0.0421),
        (5.0, 0.12), (8.0, 0.2),
    ),
)  # fmt: skip
BOUND_RATIO = 1.005


def read(kind: str, name: str) -> np.ndarray:
    flag = cv2.IMREAD_UNCHANGED if kind == "depth" else cv2.IMREAD_GRAYSCALE
    image = cv2.imread(str(frames.folder_of("tum_pairs") / kind / f"{name}.png"), flag)
    if image is None:
        raise FileNotFoundError(f"tum_pairs/{kind}/{name}.png")
    return image


def residuals(
    host: np.ndarray, Z: np.ndarray, target: np.ndarray, camera: PinholeCamera, T: np.ndarray
) -> np.ndarray:
    """I_h(p) − I_t(p'), bilinear, (H, W); NaN without depth or out of view. Independent of the
    library's own warp."""
    v, u = np.indices(host.shape, dtype=np.float64)
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)])
    x, y, z = np.einsum("ij,jvu->ivu", T[:3, :3], rays * Z) + T[:3, 3, None, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    height, width = target.shape
    valid = (Z > 0) & (z > 0) & (u >= 0) & (v >= 0) & (u < width - 1) & (v < height - 1)
    u, v = np.where(valid, u, 0.0), np.where(valid, v, 0.0)
    column, row = u.astype(int), v.astype(int)
    f, g = u - column, v - row
    grey = target.astype(np.float64)
    top = (1 - f) * grey[row, column] + f * grey[row, column + 1]
    bottom = (1 - f) * grey[row + 1, column] + f * grey[row + 1, column + 1]
    return np.where(valid, host - ((1 - g) * top + g * bottom), np.nan)


def residual_ratio(pair: Pair, T: np.ndarray) -> tuple[float, float]:
    """Mean |r| at T over that at the published pose, on the published pose's mask, and the latter.

    A pixel of the mask that T moves out of view counts with neither.
    """
    host, target = read("rgb", pair.host), read("rgb", pair.target)
    Z = read("depth", pair.depth) / DEPTH_SCALE
    theirs = residuals(host, Z, target, pair.camera, pair.truth)
    ours = residuals(host, Z, target, pair.camera, T)
    both = np.isfinite(theirs) & np.isfinite(ours)
    reference = float(np.abs(theirs[both]).mean())
    return float(np.abs(ours[both]).mean()) / reference, reference


def solve(pair: Pair, options: TrackingOptions, broken: bool) -> dict:
    names = {"host": pair.host, "target": pair.target}
    if broken:
        names[pair.broken] += "_broken"
    D, V = inverse_depth(read("depth", pair.depth), depth_scale=DEPTH_SCALE)
    keyframe = Keyframe(read("rgb", names["host"]), pair.camera, inverse_depth=D, variance=V)
    result = align(keyframe, read("rgb", names["target"]), options=options)
    metres, degrees = frames.pose_error(result.T_th, pair.truth)
    ratio, reference = residual_ratio(pair, result.T_th)
    bounds = pair.broken_bounds if broken else pair.bounds
    return {
        "broken": broken,
        "status": result.status.name,
        "mm": 1e3 * metres,
        "deg": degrees,
        "bounds": list(bounds),
        "within": bool(result.ok and 1e3 * metres <= bounds[0] and degrees <= bounds[1]),
        "residual_ratio": ratio,
        "published_residual": reference,
        "a": result.a,
        "b": result.b,
    }


def measure() -> list[dict]:
    """From the identity, photometric; the defaults and down to the full image."""
    if not frames.folder_of("tum_pairs").is_dir():
        return []
    rows = []
    for number, pair in enumerate(PAIRS, 1):
        for finest in (1, 0):
            options = TrackingOptions(finest_level=finest)
            for broken in (False, True):
                rows.append(
                    {"pair": number, "finest_level": finest, **solve(pair, options, broken)}
                )
    return rows
