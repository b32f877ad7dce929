"""`raylign synthetic sequence`: a rendered RGB-D sequence with its truth, in the TUM format."""

import enum
import itertools
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console

from raylign import synthetic
from raylign._typing import F64
from raylign.camera import PinholeCamera
from raylign.cli._console import make_console, say
from raylign.cli._options import choice_option
from raylign.cli._progress import count_progress
from raylign.depth import DepthModel
from raylign.io import TumSequenceWriter

_FIRST_STAMP_S = 1000.0  # stamps of the format are seconds of a clock that nobody starts at 0
_FOCAL_PER_WIDTH = 525.0 / 640.0  # ROS' default camera, what readers take for an unknown one


class SceneKind(enum.StrEnum):
    """What is photographed."""

    ROOM = "room"
    BOXES = "boxes"
    PLANE = "plane"
    HEIGHT_FIELD = "height_field"
    SPHERE = "sphere"
    BOARD = "board"


class MotionKind(enum.StrEnum):
    """raylign.synthetic.Motion."""

    STATIC = "static"
    ROTATION = "rotation"
    X = "x"
    Z = "z"
    ARC = "arc"
    HANDHELD = "handheld"


class Antialias(enum.StrEnum):
    """raylign.Antialiasing."""

    NONE = "none"
    BANDLIMIT = "bandlimit"
    SUPERSAMPLE = "supersample"


class DepthKind(enum.StrEnum):
    """How depth is measured."""

    KINECT = "kinect"
    CONSTANT = "constant"
    EXACT = "exact"


_SCENES: dict[SceneKind, Callable[[int], synthetic.Scene]] = {
    SceneKind.ROOM: lambda seed: synthetic.room(seed=seed),
    SceneKind.BOXES: lambda seed: synthetic.boxes(seed=seed),
    SceneKind.PLANE: lambda seed: synthetic.plane(seed=seed),
    SceneKind.HEIGHT_FIELD: lambda seed: synthetic.height_field(seed=seed),
    SceneKind.SPHERE: lambda seed: synthetic.sphere(seed=seed),
    SceneKind.BOARD: lambda seed: synthetic.room(seed=seed) + synthetic.board(seed=seed),
}


SceneOpt = Annotated[SceneKind, choice_option(SceneKind, "--scene", help="What is seen")]
MotionOpt = Annotated[MotionKind, choice_option(MotionKind, "--motion", help="Camera path")]
AntialiasOpt = Annotated[
    Antialias, choice_option(Antialias, "--antialiasing", help="How rays become a pixel")
]
DepthOpt = Annotated[DepthKind, choice_option(DepthKind, "--depth", help="Depth camera")]
OutputOpt = Annotated[
    Path, typer.Option("--output", "-o", help="Folder to write, made if need be; must be empty.")
]
FramesOpt = Annotated[int, typer.Option("--frames", "-n", min=1, help="Number of frames.")]
FpsOpt = Annotated[float, typer.Option("--fps", help="Frames per second, > 0.")]
ExtentOpt = Annotated[float, typer.Option("--extent", help="Length of the path, m.")]
AngleOpt = Annotated[float, typer.Option("--angle-deg", help="Turn of the path, degrees.")]
WidthOpt = Annotated[int, typer.Option("--width", help="Columns, px.")]
HeightOpt = Annotated[int, typer.Option("--height", help="Rows, px.")]
FocalOpt = Annotated[
    float, typer.Option("--focal", help="Focal length, px; 0: 525 px per 640 px of width.")
]
ExposureOpt = Annotated[
    float, typer.Option("--exposure-time", help="Motion blur: part of the frame interval.")
]
ReadoutOpt = Annotated[
    float, typer.Option("--readout-time", help="Rolling shutter: part of the frame interval.")
]
ReadNoiseOpt = Annotated[float, typer.Option("--read-noise", help="Sigma in grey values, >= 0.")]
ShotNoiseOpt = Annotated[float, typer.Option("--shot-noise", help="Variance per grey value, >= 0.")]
VignetteOpt = Annotated[
    float, typer.Option("--vignette-r2", help="Brightness change at the corners, > -1.")
]
ExposureChangeOpt = Annotated[
    float,
    typer.Option("--exposure-change", help="Largest change of the exposure, a part of it, < 1."),
]
SeedOpt = Annotated[int, typer.Option("--seed", min=0, help="Everything follows from it.")]
ThreadsOpt = Annotated[
    int, typer.Option("--num-threads", help="0: one per processor; same bits anyhow.")
]
QuietOpt = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]


def sequence(
    output: OutputOpt,
    scene: SceneOpt = SceneKind.ROOM,
    motion: MotionOpt = MotionKind.HANDHELD,
    frames: FramesOpt = 100,
    fps: FpsOpt = 30.0,
    extent: ExtentOpt = 0.3,
    angle_deg: AngleOpt = 10.0,
    width: WidthOpt = 640,
    height: HeightOpt = 480,
    focal: FocalOpt = 0.0,
    antialiasing: AntialiasOpt = Antialias.BANDLIMIT,
    exposure_time: ExposureOpt = 0.0,
    readout_time: ReadoutOpt = 0.0,
    read_noise: ReadNoiseOpt = 1.0,
    shot_noise: ShotNoiseOpt = 0.02,
    vignette_r2: VignetteOpt = 0.0,
    exposure_change: ExposureChangeOpt = 0.0,
    depth: DepthOpt = DepthKind.KINECT,
    seed: SeedOpt = 0,
    num_threads: ThreadsOpt = 0,
    quiet: QuietOpt = False,
) -> None:
    """Render an RGB-D sequence with its truth, in the format of the TUM benchmark.

    Writes rgb/, depth/ (16 bits, 1/5000 m), rgb.txt, depth.txt, groundtruth.txt, calibration.yaml.
    Ctrl-C keeps the frames so far.
    """
    focal = focal or _FOCAL_PER_WIDTH * width
    camera = PinholeCamera(focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))
    options = synthetic.RenderOptions(
        antialiasing=antialiasing.value,
        exposure_time=exposure_time,
        readout_time=readout_time,
        num_threads=num_threads or os.cpu_count() or 1,
    )
    sensor = synthetic.SensorOptions(
        read_noise=read_noise, shot_noise=shot_noise, vignette_r2=vignette_r2
    )
    stamps, T_wc = synthetic.trajectory(
        motion.value, n=frames, extent=extent, angle_deg=angle_deg, fps=fps, seed=seed
    )
    rendered = synthetic.render_sequence(
        _SCENES[scene](seed),
        camera,
        T_wc,
        width=width,
        height=height,
        options=options,
        sensor=_exposures(sensor, exposure_change, frames),
        depth_sensor=_depth_sensor(depth),
        seed=seed,
    )
    first = next(rendered)  # bad options show before anything is written
    writer = TumSequenceWriter(output, camera=camera, width=width, height=height)
    console = make_console(quiet=quiet)
    _write(writer, stamps, itertools.chain([first], rendered), console)
    say(console, f"wrote {frames} frames to {output}")


def _write(
    writer: TumSequenceWriter,
    stamps: F64,
    frames: Iterable[synthetic.SequenceFrame],
    console: Console,
) -> None:
    with writer, count_progress(console, "rendering") as progress:
        for i, (stamp, frame) in enumerate(zip(stamps.tolist(), frames, strict=True)):
            image = frame.truth.image
            writer.add(_FIRST_STAMP_S + stamp, image=image, depth=frame.depth, T_wc=frame.T_wc)
            progress(i + 1, len(stamps))


def _exposures(
    sensor: synthetic.SensorOptions, change: float, frames: int
) -> list[synthetic.SensorOptions]:
    """Brighter, darker and back, once over the sequence."""
    swing = np.sin(np.linspace(0.0, 2.0 * np.pi, frames))
    return [sensor.replace(exposure=1.0 + change * float(s)) for s in swing]


def _depth_sensor(kind: DepthKind) -> synthetic.DepthSensorOptions:
    if kind is DepthKind.KINECT:
        return synthetic.DepthSensorOptions()
    model = DepthModel(noise="constant", edge_ratio=0.0, edge_radius=0)
    return synthetic.DepthSensorOptions(
        model=model,
        noise=0.0 if kind is DepthKind.EXACT else 1.0,
        inverse_depth_step=0.0,
        max_incidence_deg=90.0,
    )
