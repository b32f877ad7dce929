"""Two RGB-D pairs of the TUM benchmark with a published photometric answer."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import raylign
from raylign.geometry import se3_exp, se3_log
from raylign.tracking import Keyframe, align

cv2 = pytest.importorskip("cv2")
pytestmark = pytest.mark.data


class Pair(NamedTuple):
    host: str
    host_depth: str
    target: str
    intrinsics: tuple[float, float, float, float]
    xi: tuple[float, ...]
    limits: tuple[float, float]  # mm and degrees, from identity
    broken: str
    broken_limits: tuple[float, float]


PAIRS = [
    Pair(
        "1305031102.275326",
        "1305031102.262886",
        "1305031102.175304",
        (517.3, 516.5, 318.6, 255.3),
        (-0.0018, 0.0065, 0.0369, -0.0287, -0.0184, -0.0004),
        (0.5, 0.03),
        "target",
        (2.0, 0.06),
    ),
    Pair(
        "1341847980.722988",
        "1341847980.723020",
        "1341847982.998783",
        (535.4, 539.2, 320.1, 247.6),
        (0.2979, -0.0106, 0.0452, -0.0041, -0.0993, -0.0421),
        (5.0, 0.12),
        "host",
        (8.0, 0.2),
    ),
]


def load(folder: Path, pair: Pair, *, broken: bool) -> tuple[Keyframe, np.ndarray]:
    def image(name: str, is_broken: bool) -> np.ndarray:
        suffix = "_broken" if is_broken else ""
        return cv2.imread(str(folder / "rgb" / f"{name}{suffix}.png"), cv2.IMREAD_GRAYSCALE)

    depth = cv2.imread(str(folder / "depth" / f"{pair.host_depth}.png"), cv2.IMREAD_UNCHANGED)
    D, V = raylign.depth.inverse_depth(depth, depth_scale=5000.0)
    camera = raylign.camera.PinholeCamera(*pair.intrinsics)
    host = image(pair.host, broken and pair.broken == "host")
    target = image(pair.target, broken and pair.broken == "target")
    return Keyframe(host, camera, inverse_depth=D, variance=V), target


def mean_residual(folder: Path, pair: Pair, T_th: np.ndarray) -> float:
    """Mean |I_h − I_t(p')| over the pixels with depth that are in view at the published pose."""

    def read(kind: str, name: str) -> np.ndarray:
        flag = cv2.IMREAD_GRAYSCALE if kind == "rgb" else cv2.IMREAD_UNCHANGED
        return cv2.imread(str(folder / kind / f"{name}.png"), flag).astype(np.float32)

    host, target = read("rgb", pair.host), read("rgb", pair.target)
    Z = read("depth", pair.host_depth).astype(np.float64) / 5000.0
    camera = raylign.camera.PinholeCamera(*pair.intrinsics)
    v, u = np.mgrid[0 : Z.shape[0], 0 : Z.shape[1]]
    X = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(Z)], -1)
    X = X * Z[..., None]

    def project(T: np.ndarray) -> np.ndarray:
        return camera.project(X @ T[:3, :3].T + T[:3, 3])[0]

    published = project(se3_exp(pair.xi))
    inside = (published >= 0) & (published <= np.array([639, 479]))
    mask = (Z > 0) & inside.all(axis=-1)
    uv = project(T_th).astype(np.float32)
    warped = cv2.remap(target, uv[..., 0], uv[..., 1], cv2.INTER_LINEAR, cv2.BORDER_REPLICATE)
    return float(np.abs(host - warped)[mask].mean())


def distance(T: np.ndarray, pair: Pair) -> tuple[float, float]:
    xi = se3_log(T @ np.linalg.inv(se3_exp(pair.xi)))
    return 1e3 * float(np.linalg.norm(xi[:3])), float(np.degrees(np.linalg.norm(xi[3:])))


def assert_within(found: tuple[float, float], limits: tuple[float, float]) -> None:
    np.testing.assert_array_less(found, limits)


@pytest.mark.parametrize("pair", PAIRS, ids=["near", "far"])
def test_published_answer_is_met(shared_data: Path, pair: Pair) -> None:
    folder = shared_data / "tum_pairs"
    host, target = load(folder, pair, broken=False)
    result = align(host, target)
    assert result.ok
    assert_within(distance(result.T_th, pair), pair.limits)
    ours = mean_residual(folder, pair, result.T_th)
    assert ours <= 1.005 * mean_residual(folder, pair, se3_exp(pair.xi))


@pytest.mark.parametrize("pair", PAIRS, ids=["near", "far"])
def test_scribbled_images_are_survived(shared_data: Path, pair: Pair) -> None:
    host, target = load(shared_data / "tum_pairs", pair, broken=True)
    result = align(host, target)
    assert result.ok, result.reason
    assert_within(distance(result.T_th, pair), pair.broken_limits)
