"""`raylign demo --scene room`: photometric bundle adjustment of a rendered room."""

from pathlib import Path

import numpy as np
from rich.console import Console

import raylign.photometric as library
from raylign import synthetic
from raylign._typing import F64
from raylign.camera import PinholeCamera
from raylign.cli._choices import LogStyle
from raylign.cli._console import say
from raylign.cli._progress import PhotometricDisplay
from raylign.depth import DepthModel
from raylign.errors import Error
from raylign.geometry import se3_exp

_WIDTH, _HEIGHT = 320, 240
_CAMERA = PinholeCamera(262.0, 262.0, 159.5, 119.5)
_NUM_IMAGES = 5
_NUM_POINTS = 600


def refine_room(output: Path, console: Console) -> library.PhotometricResult:
    """Render, disturb the poses, refine, write the report; say how far off the cameras are.

    Raises:
        Error: the solve failed.
    """
    steps = [[0.06 * i, 0.0, 0.0, 0.0, -0.02 * i, 0.01 * i] for i in range(_NUM_IMAGES)]
    T_true = se3_exp(steps)
    problem = _disturbed(T_true)
    say(console, f"rendered room, noise of two grey levels: {problem!r}")
    display = PhotometricDisplay(console, LogStyle.TABLE)
    with display.running():
        result = library.adjust(problem, callback=display)
    if not result.summary.is_usable():
        raise Error(f"the solve failed: {result.summary.message}")
    from raylign.viz import photometric_report  # matplotlib: late

    with console.status("drawing"):
        photometric_report(
            result, output, title="raylign demo: a rendered room, refined from grey values"
        )
    say(console, result.full_report())
    before, after = (_center_rmse(T, T_true) for T in (problem.T_cw, result.T_cw))
    say(console, f"camera centres off by {1e3 * before:.2f} mm before, {1e3 * after:.2f} mm after")
    return result


def _disturbed(T_true: F64) -> library.Problem:
    scene, frames = synthetic.room(seed=1), []
    for i, T in enumerate(T_true):
        sensor = synthetic.SensorOptions(read_noise=2.0, exposure=1.0 + 0.05 * i)
        frames.append(
            synthetic.render(
                scene, _CAMERA, T, width=_WIDTH, height=_HEIGHT, sensor=sensor, index=i
            )
        )
    errors = np.random.default_rng(0).normal(0.0, 0.004, (_NUM_IMAGES, 6))
    errors[:, 3:] *= 0.5
    errors[0] = 0.0
    return library.Problem.from_depth(
        [frame.image for frame in frames],
        [frame.depth for frame in frames],
        _CAMERA,
        se3_exp(errors) @ T_true,
        _NUM_POINTS,
        depth_model=DepthModel(),
    )


def _center_rmse(T_cw: F64, T_true: F64) -> float:
    """RMS distance of the camera centres, m."""

    def centers(T: F64) -> F64:
        return np.asarray(-np.einsum("nji,nj->ni", T[:, :3, :3], T[:, :3, 3]))

    return float(np.sqrt(np.mean(np.sum((centers(T_cw) - centers(T_true)) ** 2, axis=1))))
