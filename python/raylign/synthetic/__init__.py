"""Known-truth scenes for experiments and for users' own tests.

`bal` makes bundle adjustment problems of 2 to 100 000 cameras with their answer: a vehicle that
drives laps through a city (`BalKind.STREET`, with loop closures) or a photo collection around a
building (`BalKind.ORBIT`). World frame: metres, z up. Every number is a function of the options:
the same seed gives the same bits on every machine, and turning one knob (say, the pixel noise)
leaves the draws behind the others as they were.

`render` makes images by casting rays into textured scenes (`room`, `plane`, `boxes`,
`height_field`, `sphere`, `board`), with depth, normals and poses that are exact by construction:

    >>> from raylign.camera import PinholeCamera
    >>> import numpy as np
    >>> camera = PinholeCamera(120.0, 120.0, 79.5, 59.5)
    >>> frame = render(room(seed=1), camera, np.eye(4), width=160, height=120)
    >>> frame.image.shape, frame.image.dtype, frame.depth.dtype, bool(frame.valid.all())
    ((120, 160), dtype('uint8'), dtype('float64'), True)

The world frame of these scenes is that of a camera that sees them well: x right, y down, z forward,
metres.
"""

from raylign._core import (
    Antialiasing,
    BalKind,
    BalOptions,
    DepthSensorOptions,
    HeightFieldOptions,
    PixelType,
    RenderOptions,
    Scene,
    SensorOptions,
    SensorResponse,
    TextureKind,
    TextureOptions,
)
from raylign.synthetic._bal import SyntheticBal, bal, write_bal
from raylign.synthetic._depth_camera import noise_field, sense_depth
from raylign.synthetic._render import Frame, expose, render
from raylign.synthetic._scenes import board, boxes, height_field, look_at, plane, room, sphere
from raylign.synthetic._sequence import SequenceFrame, render_sequence
from raylign.synthetic._trajectory import Motion, trajectory

__all__ = [
    "Antialiasing",
    "BalKind",
    "BalOptions",
    "DepthSensorOptions",
    "Frame",
    "HeightFieldOptions",
    "Motion",
    "PixelType",
    "RenderOptions",
    "Scene",
    "SensorOptions",
    "SensorResponse",
    "SequenceFrame",
    "SyntheticBal",
    "TextureKind",
    "TextureOptions",
    "bal",
    "board",
    "boxes",
    "expose",
    "height_field",
    "look_at",
    "noise_field",
    "plane",
    "render",
    "render_sequence",
    "room",
    "sense_depth",
    "sphere",
    "trajectory",
    "write_bal",
]
