"""Camera paths for rendered sequences."""

import enum

import numpy as np
import numpy.typing as npt

from raylign._typing import F64
from raylign.errors import OptionsError, ShapeError
from raylign.geometry import se3_exp


class Motion(enum.Enum):
    """How the camera of `trajectory` moves, in its own starting frame."""

    STATIC = "static"
    """Not at all."""
    ROTATION = "rotation"
    """Turns about the image's y axis by `angle_deg` in all, with a little pitch and roll."""
    X = "x"
    """To the right by `extent` in all."""
    Z = "z"
    """Forward by `extent` in all."""
    ARC = "arc"
    """Along a circle about a point `radius` in front, to the right and always facing the point;
    by `angle_deg` in all."""
    HANDHELD = "handheld"
    """As a hand does: sums of slow sinusoids, within about `extent` and `angle_deg`."""


def trajectory(
    motion: Motion | str,
    *,
    n: int = 100,
    extent: float = 0.3,
    angle_deg: float = 10.0,
    radius: float = 2.5,
    fps: float = 30.0,
    start: npt.ArrayLike | None = None,
    seed: int = 0,
) -> tuple[F64, F64]:
    """Poses of a camera that moves smoothly from `start` on.

    Args:
        motion: kind, or its lower-case name: static, rotation, x, z, arc, handheld.
        n: poses, >= 1.
        extent: way in m: in all for X and Z, from side to side for HANDHELD.
        angle_deg: turn in degrees: in all for ROTATION and ARC, from side to side for HANDHELD.
        radius: of the ARC in m, > 0.
        fps: poses per second, > 0.
        start: (4, 4) T_wc of the first pose; default: the identity.
        seed: draws the HANDHELD path.

    Returns:
        timestamps (N,) float64 in s from 0 on, T_wc (N, 4, 4) float64; T_wc[0] = start.

    Raises:
        OptionsError: an argument is out of range.
        ShapeError: `start` is not (4, 4).

    Example:
        >>> stamps, T_wc = trajectory("x", n=4, extent=0.3)
        >>> T_wc[:, 0, 3].round(3).tolist(), round(float(stamps[3]), 3)
        ([0.0, 0.1, 0.2, 0.3], 0.1)
    """
    kind = _motion(motion)
    for name, value, low in (("n", n, 1), ("extent", extent, None), ("angle_deg", angle_deg, None)):
        _check(name, value, low)
    _check("radius", radius, 1e-9)
    _check("fps", fps, 1e-9)
    first = np.eye(4) if start is None else np.asarray(start, np.float64)
    if first.shape != (4, 4):
        raise ShapeError(f"start must be of shape (4, 4), got {first.shape}")
    stamps = np.arange(n) / fps
    progress = np.linspace(0.0, 1.0, n) if n > 1 else np.zeros(1)
    turn = np.deg2rad(angle_deg)
    if kind is Motion.HANDHELD:
        return stamps, first @ _handheld(stamps, extent, turn, seed)
    if kind is Motion.ARC:
        return stamps, first @ _arc(progress * turn, radius)
    tangent = {
        Motion.STATIC: np.zeros(6),
        Motion.ROTATION: turn * np.array([0.0, 0.0, 0.0, 0.2, 1.0, 0.1]) / np.sqrt(1.05),
        Motion.X: np.array([extent, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Motion.Z: np.array([0.0, 0.0, extent, 0.0, 0.0, 0.0]),
    }[kind]
    return stamps, first @ se3_exp(progress[:, None] * tangent)


def _motion(motion: Motion | str) -> Motion:
    if isinstance(motion, Motion):
        return motion
    known = {m.name.lower(): m for m in Motion}
    if motion not in known:
        raise OptionsError(f"motion must be one of {', '.join(known)}, got {motion!r}")
    return known[motion]


def _check(name: str, value: float, low: float | None) -> None:
    if not np.isfinite(value) or (low is not None and value < low):
        rule = "finite" if low is None else (">= 1" if low == 1 else "finite and > 0")
        raise OptionsError(f"{name} must be {rule}, got {value}")


def _arc(angles: F64, radius: float) -> F64:
    """T_0t on the circle: turn about the point, to the right, facing it."""
    T = np.tile(np.eye(4), (len(angles), 1, 1))
    T[:, :3, :3] = se3_exp(np.outer(-angles, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]))[:, :3, :3]
    T[:, :3, 3] = [0.0, 0.0, radius] - radius * T[:, :3, 2]
    return T


def _handheld(stamps: F64, extent: float, turn: float, seed: int) -> F64:
    """Four sinusoids of 0.15 to 1.2 Hz per coordinate, amplitude ~ 1/frequency; T(0) = identity."""
    random = np.random.default_rng([seed, 0x4A])
    frequency = random.uniform(0.15, 1.2, (6, 4))
    phase = random.uniform(0.0, 2.0 * np.pi, (6, 4))
    weight = random.uniform(0.5, 1.0, (6, 4)) / frequency
    weight *= 0.5 / weight.sum(axis=1, keepdims=True)
    wave = np.sin(2.0 * np.pi * frequency * stamps[:, None, None] + phase) - np.sin(phase)
    xi = (weight * wave).sum(axis=-1) * np.repeat([extent, turn], 3)
    return se3_exp(xi)
