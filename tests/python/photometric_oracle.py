"""The direct bundle adjustment exercise in plain NumPy, without any raylign code.

Follows the exercise, not good sense: bilinear grey values with central differences for their
gradient, Huber's law with threshold 1 on the norm of a patch, no gauge, g2o's additive damping, and
an error of zero for a patch that is out of view. Pixel coordinates, intrinsics and interpolation
are float32, as there. A second reading of docs/theory/photometric.md for the tests.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from oracle import rotation_matrices

FX, FY, CX, CY = (np.float32(x) for x in (277.34, 291.402, 312.234, 239.777))
WIDTH, HEIGHT = 640, 480
OFFSETS = np.array([(du, dv) for du in range(-2, 2) for dv in range(-2, 2)])  # by columns
HUBER = 1.0


@dataclass(frozen=True)
class Exercise:
    """R (M, 3, 3) and t (M, 3) of T_cw; points (N, 3); patches (N, 16); images M x (H, W)."""

    R: np.ndarray
    t: np.ndarray
    points: np.ndarray
    patches: np.ndarray
    images: list[np.ndarray]


def load(folder: Path, *, copy_image_1: bool) -> Exercise:
    """Read the data; `copy_image_1` puts a copy of image 1 in the place of image 0."""
    poses = np.loadtxt(folder / "poses.txt")
    x, y, z, w = poses[:, 4:].T / np.linalg.norm(poses[:, 4:], axis=1)
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    table = np.loadtxt(folder / "points.txt")
    names = [1 if copy_image_1 and i == 0 else i for i in range(len(poses))]
    images = [cv2.imread(str(folder / f"{i}.png"), cv2.IMREAD_GRAYSCALE) for i in names]
    return Exercise(R, poses[:, 1:4], table[:, :3], table[:, 3:], images)


def grey(image: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Bilinear, reading on into the next row behind the last column, as a pointer does."""
    flat = np.append(image.ravel(), np.zeros(2 * WIDTH, np.uint8)).astype(np.float32)
    at = np.trunc(v).astype(np.int64) * WIDTH + np.trunc(u).astype(np.int64)
    x, y, one = u - np.floor(u), v - np.floor(v), np.float32(1.0)
    return (
        (one - x) * (one - y) * flat[at]
        + x * (one - y) * flat[at + 1]
        + (one - x) * y * flat[at + WIDTH]
        + x * y * flat[at + WIDTH + 1]
    )


def view(state: Exercise, j: int):
    """Of camera j: the points in its frame (N, 3), and pixels u, v (N,) float32."""
    q = state.points @ state.R[j].T + state.t[j]
    u = (FX * q[:, 0] / q[:, 2] + CX).astype(np.float32)
    v = (FY * q[:, 1] / q[:, 2] + CY).astype(np.float32)
    return q, u, v


def in_view(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The exercise's border rule: it looks at the corners of the patch, not at the depth."""
    return ~((u - 2 < 0) | (v - 2 < 0) | (u + 1 >= WIDTH) | (v + 1 >= HEIGHT))


def seen(state: Exercise) -> np.ndarray:
    """(M, N) which points are in view of which camera."""
    return np.array([in_view(*view(state, j)[1:]) for j in range(len(state.R))])


def errors(state: Exercise, j: int):
    """Errors (N, 16) of camera j, zero where the patch is out of view, and who is in view."""
    _, u, v = view(state, j)
    inside = in_view(u, v)
    e = np.zeros((len(u), 16))
    for n, (du, dv) in enumerate(OFFSETS):
        value = grey(state.images[j], u[inside] + np.float32(du), v[inside] + np.float32(dv))
        e[inside, n] = state.patches[inside, n] - value
    return e, inside


def cost(state: Exercise) -> float:
    """What the exercise prints as chi2: the sum of robustified squared norms."""
    s = np.array([np.sum(errors(state, j)[0] ** 2, axis=1) for j in range(len(state.R))])
    return float(np.sum(np.where(s <= HUBER**2, s, 2 * HUBER * np.sqrt(s) - HUBER**2)))


def jacobians(state: Exercise, j: int):
    """Of the errors of camera j with respect to [translation; rotation] (N, 16, 6) and X."""
    q, u, v = view(state, j)
    inside = in_view(u, v)
    slope = np.zeros((len(u), 16, 2))
    step = np.float32(1.0)
    for n, (du, dv) in enumerate(OFFSETS):
        un, vn = u[inside] + np.float32(du), v[inside] + np.float32(dv)
        image = state.images[j]
        slope[inside, n, 0] = 0.5 * (grey(image, un + step, vn) - grey(image, un - step, vn))
        slope[inside, n, 1] = 0.5 * (grey(image, un, vn + step) - grey(image, un, vn - step))
    x, y, iz = q[:, 0] / q[:, 2], q[:, 1] / q[:, 2], 1.0 / q[:, 2]
    o = np.zeros_like(x)
    du_dq = np.array([[FX * iz, o, -FX * x * iz], [o, FY * iz, -FY * y * iz]]).transpose(2, 0, 1)
    du_dxi = np.array(
        [
            [FX * iz, o, -FX * x * iz, -FX * x * y, FX * (1 + x * x), -FX * y],
            [o, FY * iz, -FY * y * iz, -FY * (1 + y * y), FY * x * y, FY * x],
        ]
    ).transpose(2, 0, 1)
    return -slope @ du_dxi, -slope @ (du_dq @ state.R[j])


@dataclass(frozen=True)
class NormalEquations:
    """H of cameras (M, 6, 6), points (N, 3, 3), mixed (M, N, 6, 3) and gradients."""

    cameras: np.ndarray
    points: np.ndarray
    mixed: np.ndarray
    b_cameras: np.ndarray
    b_points: np.ndarray

    def max_diagonal(self) -> float:
        diagonals = (np.diagonal(H, axis1=1, axis2=2).max() for H in (self.cameras, self.points))
        return float(max(diagonals))


def linearize(state: Exercise, alive: np.ndarray) -> NormalEquations:
    """Gauss-Newton with the weights 1 / |e| of Huber's law; `alive` (M, N): edges with gradient."""
    M, N = len(state.R), len(state.points)
    H = NormalEquations(*map(np.zeros, [(M, 6, 6), (N, 3, 3), (M, N, 6, 3), (M, 6), (N, 3)]))
    for j in range(M):
        e, _ = errors(state, j)
        J_c, J_p = (np.where(alive[j][:, None, None], J, 0.0) for J in jacobians(state, j))
        norm = np.linalg.norm(e, axis=1)
        w = np.where(norm <= HUBER, 1.0, HUBER / np.maximum(norm, HUBER))[:, None, None]
        H.cameras[j] = np.einsum("nki,nkj->ij", J_c, w * J_c)
        H.points[:] += J_p.transpose(0, 2, 1) @ (w * J_p)
        H.mixed[j] = J_c.transpose(0, 2, 1) @ (w * J_p)
        H.b_cameras[j] = -np.einsum("nki,nk->i", w * J_c, e)
        H.b_points[:] -= np.einsum("nki,nk->ni", w * J_p, e)
    return H


def step(state: Exercise, H: NormalEquations, damping: float) -> tuple[Exercise, float]:
    """One step with `damping` added to the whole diagonal; the new state and g2o's model gain."""
    M, N = len(state.R), len(state.points)
    V_inverse = np.linalg.inv(H.points + damping * np.eye(3))
    W = H.mixed.transpose(1, 0, 2, 3).reshape(N, 6 * M, 3)
    WV = W @ V_inverse
    S = np.zeros((6 * M, 6 * M))
    for j in range(M):
        S[6 * j : 6 * j + 6, 6 * j : 6 * j + 6] = H.cameras[j]
    S += damping * np.eye(6 * M) - np.einsum("nik,njk->ij", WV, W)
    rhs = H.b_cameras.ravel() - np.einsum("nik,nk->i", WV, H.b_points)
    xi = np.linalg.solve(S, rhs)
    dX = np.einsum("nij,nj->ni", V_inverse, H.b_points - np.einsum("nik,i->nk", W, xi))
    x, b = np.append(xi, dX), np.append(H.b_cameras, H.b_points)
    xi = xi.reshape(M, 6)
    dR, V = exp(xi)
    R = dR @ state.R
    t = (dR @ state.t[..., None])[..., 0] + (V @ xi[:, :3, None])[..., 0]
    gain = float(x @ (damping * x + b))
    return replace(state, R=R, t=t, points=state.points + dX), gain


def exp(xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotations and V of SE(3)'s exponential; V by its series, which small steps exhaust."""
    dR = rotation_matrices(xi[:, 3:])
    K = np.zeros((len(xi), 3, 3))
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -xi[:, 5], xi[:, 4], -xi[:, 3]
    K -= K.transpose(0, 2, 1)
    V, term = np.zeros_like(K), np.tile(np.eye(3), (len(xi), 1, 1))
    for k in range(1, 20):
        V += term
        term = term @ K / (k + 1.0)
    return dR, V


def levenberg(state: Exercise, num_steps: int):
    """g2o's loop: yields (state, chi2, lambda after the step) per iteration.

    An edge that was out of view once, be it in a refused trial, never has a gradient again, while
    its error counts whenever it is in view: the exercise marks it with setLevel(1).
    """
    current, growth = cost(state), 2.0
    alive = seen(state)
    damping = 1e-5 * linearize(state, alive).max_diagonal()
    for _iteration in range(num_steps):
        H = linearize(state, alive)
        for _trial in range(10):
            candidate, gain = step(state, H, damping)
            alive &= seen(candidate)
            new = cost(candidate)
            rho = (current - new) / (gain + 1e-3)
            if rho > 0.0:
                damping *= max(1.0 / 3.0, min(2.0 / 3.0, 1.0 - (2.0 * rho - 1.0) ** 3))
                growth, state, current = 2.0, candidate, new
                break
            damping *= growth
            growth *= 2.0
        yield state, current, damping
