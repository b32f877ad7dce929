"""Whole sequences of rendered frames."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from raylign._core import (
    DepthSensorOptions,
    PinholeCamera,
    RadtanCamera,
    RenderOptions,
    Scene,
    SensorOptions,
)
from raylign._typing import F32, F64
from raylign.errors import ShapeError
from raylign.geometry import se3_inverse, se3_log
from raylign.synthetic._depth_camera import sense_depth
from raylign.synthetic._render import Frame, render


@dataclass(frozen=True)
class SequenceFrame:
    """One of `render_sequence`.

    Attributes:
        truth: the rendered frame; `truth.image` is what the camera took.
        depth: (H, W) float32 m, what the depth camera took; NaN where it reports nothing.
        T_wc: (4, 4) float64 true pose.
    """

    truth: Frame
    depth: F32
    T_wc: F64


def render_sequence(
    scene: Scene,
    camera: PinholeCamera | RadtanCamera,
    T_wc: npt.ArrayLike,
    *,
    width: int,
    height: int,
    options: RenderOptions | None = None,
    sensor: SensorOptions | Sequence[SensorOptions] | None = None,
    depth_sensor: DepthSensorOptions | None = None,
    seed: int = 0,
) -> Iterator[SequenceFrame]:
    """Render the frames of a camera path one by one.

    Motion blur and rolling shutter (`options`) follow the path: the motion during a frame is that
    from the pose before to the pose after, halved.

    Args:
        scene: what is there.
        camera: takes both colour and depth.
        T_wc: (N, 4, 4) poses at even intervals, as `trajectory` makes them.
        width: px.
        height: px.
        options: how rays become grey values.
        sensor: how irradiance becomes an image; one for all frames, or one each (exposure changes).
        depth_sensor: how depth becomes a depth image; default: like a Kinect.
        seed: of all noise; frame i has the noise of index i.

    Yields:
        SequenceFrame: image and depth as the sensors report them, and the truth.

    Raises:
        OptionsError: an option is out of range.
        ShapeError: `T_wc` is not (N, 4, 4), or there are not as many sensors as poses.

    Example:
        >>> from raylign import camera, synthetic
        >>> pinhole = camera.PinholeCamera(50.0, 50.0, 31.5, 23.5)
        >>> _, T_wc = synthetic.trajectory("arc", n=3)
        >>> frames = synthetic.render_sequence(
        ...     synthetic.room(), pinhole, T_wc, width=64, height=48
        ... )
        >>> [frame.truth.image.shape for frame in frames]
        [(48, 64), (48, 64), (48, 64)]
    """
    poses = np.asarray(T_wc, np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise ShapeError(f"T_wc must be of shape (N, 4, 4), got {poses.shape}")
    sensors = sensor if isinstance(sensor, Sequence) else [sensor] * len(poses)
    if len(sensors) != len(poses):
        raise ShapeError(f"sensor must be one or {len(poses)}, one per pose, got {len(sensors)}")
    T_cw = se3_inverse(poses)
    for index, pose in enumerate(T_cw):
        truth = render(
            scene,
            camera,
            pose,
            width=width,
            height=height,
            options=options,
            sensor=sensors[index],
            motion=_motion_at(T_cw, index),
            seed=seed,
            index=index,
        )
        depth = sense_depth(truth, camera, options=depth_sensor, seed=seed, index=index)
        yield SequenceFrame(truth, depth, poses[index].copy())


def _motion_at(T_cw: F64, index: int) -> F64:
    """Tangent per frame interval by central, at the ends one-sided, differences."""
    before, after = max(index - 1, 0), min(index + 1, len(T_cw) - 1)
    if after == before:
        return np.zeros(6)
    motion: F64 = se3_log(T_cw[after] @ se3_inverse(T_cw[before])) / (after - before)
    return motion
