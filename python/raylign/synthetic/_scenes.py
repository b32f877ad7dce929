"""Scenes made of few textured surfaces, placed so that a camera at the identity sees them well."""

import numpy as np
import numpy.typing as npt

from raylign._core import HeightFieldOptions, Scene, TextureOptions
from raylign._typing import F64
from raylign.errors import OptionsError
from raylign.geometry import se3_inverse, so3_exp

# Where the nominal camera stands in a room, in parts of its size from the middle, and how it looks:
# into a corner, a little down and not quite level, so that no wall is parallel to the image.
_EYE = np.array([-0.175, -0.04, -0.25])
_YAW_DEG, _PITCH_DEG, _ROLL_DEG = 30.0, -4.0, 3.0


def room(
    *,
    seed: int = 0,
    size: npt.ArrayLike = (4.0, 2.6, 4.0),
    texture: TextureOptions | None = None,
) -> Scene:
    """An empty room seen from inside: six textured walls, no occlusion.

    From the identity the camera looks into a corner: depth 2.5 to 4 m in the default size, floor
    and ceiling in view.

    Args:
        seed: draws the textures.
        size: (3,) width, height and length in m, > 0.
        texture: what is painted on the walls; its seed is replaced.

    Returns:
        Scene: faces 0 to 5 are the walls −x, +x, ceiling, floor, −z, +z of the room.

    Raises:
        OptionsError: a size is not positive, or `texture` is out of range.

    Example:
        >>> from raylign import synthetic
        >>> synthetic.room(seed=3).num_faces
        6
    """
    extent = _extent(size)
    scene = Scene()
    scene.add_box(_room_pose(extent), size=extent, texture=_painted(texture, seed, 0))
    return scene


def boxes(
    *,
    n: int = 4,
    seed: int = 0,
    size: npt.ArrayLike = (4.0, 2.6, 4.0),
    texture: TextureOptions | None = None,
) -> Scene:
    """The room with `n` boxes standing about in view: depth steps and occlusion.

    Args:
        n: boxes, in [0, 1000].
        seed: draws the textures and the boxes.
        size: (3,) of the room in m, > 0.
        texture: what is painted on everything; its seed is replaced.

    Returns:
        Scene: faces 0 to 5 are the walls (see `room`), 6 + 6 i to 11 + 6 i those of box i.

    Raises:
        OptionsError: `n` or a size is out of range.

    Example:
        >>> from raylign import synthetic
        >>> synthetic.boxes(n=2).num_faces
        18
    """
    if not 0 <= n <= 1000:
        raise OptionsError(f"n must be in [0, 1000], got {n}")
    extent = _extent(size)
    scene = room(seed=seed, size=extent, texture=texture)
    T_wr = _room_pose(extent)
    random = np.random.default_rng([seed, 0xB0])
    for i in range(n):
        heading = np.deg2rad(_YAW_DEG + random.uniform(-25.0, 25.0))
        distance = random.uniform(0.5, 0.75) * extent[2]
        dimensions = random.uniform([0.08, 0.3, 0.08], [0.16, 0.6, 0.16]) * extent
        T_rb = np.eye(4)
        T_rb[:3, :3] = so3_exp([0.0, random.uniform(0.0, np.pi), 0.0])
        T_rb[:3, 3] = _EYE * extent + distance * np.array([np.sin(heading), 0.0, np.cos(heading)])
        T_rb[1, 3] = 0.5 * (extent[1] - dimensions[1])  # on the floor
        scene.add_box(T_wr @ T_rb, size=dimensions, texture=_painted(texture, seed, 1 + i))
    return scene


def plane(
    *,
    seed: int = 0,
    slant_deg: float = 30.0,
    distance: float = 2.0,
    texture: TextureOptions | None = None,
) -> Scene:
    """An endless textured plane across the optical axis.

    Args:
        seed: draws the texture.
        slant_deg: angle between the normal and the optical axis of the nominal camera, turned about
            the image's y axis (right side farther), in (−90, 90).
        distance: depth on the optical axis in m, > 0.
        texture: what is painted on it; its seed is replaced.

    Returns:
        Scene: one face; z = distance + x tan(slant).

    Raises:
        OptionsError: an argument is out of range.

    Example:
        >>> from raylign import synthetic
        >>> synthetic.plane(slant_deg=0.0).num_faces
        1
    """
    if not -90.0 < slant_deg < 90.0:
        raise OptionsError(f"slant_deg must be in (-90, 90), got {slant_deg}")
    T_ws = _at_distance(distance)
    T_ws[:3, :3] = so3_exp([0.0, -np.deg2rad(slant_deg), 0.0])
    scene = Scene()
    scene.add_rectangle(
        T_ws, width=float("inf"), height=float("inf"), texture=_painted(texture, seed, 0)
    )
    return scene


def height_field(
    *,
    seed: int = 0,
    amplitude: float = 0.15,
    distance: float = 2.5,
    texture: TextureOptions | None = None,
) -> Scene:
    """Smooth hills across the optical axis, 6 m x 4 m: curved, without depth steps.

    Args:
        seed: draws the texture and the hills.
        amplitude: standard deviation of the depth in m, >= 0.
        distance: mean depth in m, > 0.
        texture: what is painted on it; its seed is replaced.

    Returns:
        Scene: one face.

    Raises:
        OptionsError: an argument is out of range.
    """
    hills = HeightFieldOptions(amplitude=amplitude, seed=seed)
    scene = Scene()
    scene.add_height_field(
        _at_distance(distance), options=hills, texture=_painted(texture, seed, 0)
    )
    return scene


def sphere(
    *,
    seed: int = 0,
    radius: float = 0.6,
    distance: float = 2.5,
    texture: TextureOptions | None = None,
) -> Scene:
    """A ball in front of an endless wall, which stands 1.5 m behind its centre.

    Args:
        seed: draws the textures.
        radius: of the ball in m, > 0.
        distance: of its centre in m, > 0.
        texture: what is painted on both; its seed is replaced.

    Returns:
        Scene: face 0 is the ball, 1 the wall.

    Raises:
        OptionsError: an argument is out of range.
    """
    scene = Scene()
    scene.add_sphere(_at_distance(distance), radius=radius, texture=_painted(texture, seed, 0))
    scene.add(plane(seed=seed + 1, slant_deg=0.0, distance=distance + 1.5, texture=texture))
    return scene


def board(
    *,
    seed: int = 0,
    distance: float = 1.2,
    size: npt.ArrayLike = (0.5, 0.4),
    offset: npt.ArrayLike = (0.0, 0.0),
    texture: TextureOptions | None = None,
) -> Scene:
    """A plate across the optical axis, an occluder to add to another scene.

    Args:
        seed: draws the texture.
        distance: depth in m, > 0.
        size: (2,) width and height in m, > 0.
        offset: (2,) x and y of its middle in m.
        texture: what is painted on it; its seed is replaced.

    Returns:
        Scene: one face.

    Raises:
        OptionsError: an argument is out of range.

    Example:
        >>> from raylign import synthetic
        >>> (synthetic.room() + synthetic.board()).num_faces
        7
    """
    T_ws = _at_distance(distance)
    T_ws[:2, 3] = np.asarray(offset, np.float64)
    width, height = (float(x) for x in np.asarray(size, np.float64))
    scene = Scene()
    scene.add_rectangle(T_ws, width=width, height=height, texture=_painted(texture, seed, 101))
    return scene


def look_at(eye: npt.ArrayLike, target: npt.ArrayLike, *, roll_deg: float = 0.0) -> F64:
    """Pose of a camera at `eye` that looks at `target`, level in a world with y down.

    Args:
        eye: (3,) camera centre, m.
        target: (3,) point on the optical axis, m; not straight above or below.
        roll_deg: turn about the optical axis, degrees.

    Returns:
        T_wc (4, 4) float64.

    Raises:
        OptionsError: the direction is vertical or zero.

    Example:
        >>> look_at([0, 0, -1], [0, 0, 0])[:3, 3].tolist()
        [0.0, 0.0, -1.0]
    """
    position = np.asarray(eye, np.float64)
    forward = np.asarray(target, np.float64) - position
    right = np.cross([0.0, 1.0, 0.0], forward)
    if not np.linalg.norm(right) > 1e-9 * np.linalg.norm(forward):
        raise OptionsError("look_at must have a direction that is not vertical")
    right /= np.linalg.norm(right)
    forward /= np.linalg.norm(forward)
    T_wc = np.eye(4)
    T_wc[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    T_wc[:3, :3] = T_wc[:3, :3] @ so3_exp([0.0, 0.0, np.deg2rad(roll_deg)])
    T_wc[:3, 3] = position
    return T_wc


def _extent(size: npt.ArrayLike) -> F64:
    extent = np.asarray(size, np.float64)
    if extent.shape != (3,) or not (np.isfinite(extent).all() and (extent > 0.0).all()):
        raise OptionsError(f"size must be three finite numbers > 0, got {size!r}")
    return extent


def _room_pose(extent: F64) -> F64:
    """T_wr of a room whose nominal camera is the world frame."""
    yaw = so3_exp([0.0, np.deg2rad(_YAW_DEG), 0.0])
    T_rc = np.eye(4)
    T_rc[:3, :3] = yaw @ so3_exp([np.deg2rad(_PITCH_DEG), 0.0, 0.0])
    T_rc[:3, :3] = T_rc[:3, :3] @ so3_exp([0.0, 0.0, np.deg2rad(_ROLL_DEG)])
    T_rc[:3, 3] = _EYE * extent
    return se3_inverse(T_rc)


def _at_distance(distance: float) -> F64:
    if not (np.isfinite(distance) and distance > 0.0):
        raise OptionsError(f"distance must be finite and > 0, got {distance}")
    T_ws = np.eye(4)
    T_ws[2, 3] = distance
    return T_ws


def _painted(texture: TextureOptions | None, seed: int, surface: int) -> TextureOptions:
    """The texture with a seed of its own for every surface of a scene."""
    mixed = (seed + 0x9E3779B97F4A7C15 * surface) % 2**64
    return (texture or TextureOptions()).replace(seed=mixed)
