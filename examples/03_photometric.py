"""Refine rough poses from grey values alone, and compare with the truth.

    python examples/03_photometric.py [--out PICTURE]

A camera moves through a rendered room; its poses are off by millimetres and tenths of a degree.
Points are chosen from the depth of its images, and photometric bundle adjustment makes poses and
points agree with every grey value. The picture shows points by residual, patches before and after,
and the law of the residuals.
"""

import argparse
from pathlib import Path

import numpy as np

import raylign.photometric as pba
from raylign import synthetic
from raylign.camera import PinholeCamera
from raylign.depth import DepthModel
from raylign.geometry import se3_exp

WIDTH, HEIGHT = 320, 240
CAMERA = PinholeCamera(262.0, 262.0, 159.5, 119.5)
NUM_IMAGES = 5


def true_poses() -> np.ndarray:
    """A step to the right per image, turning towards what was in the middle."""
    return se3_exp([[0.06 * i, 0.0, 0.0, 0.0, -0.02 * i, 0.01 * i] for i in range(NUM_IMAGES)])


def take_pictures(T_true: np.ndarray) -> list[synthetic.Frame]:
    """Images with noise of two grey levels, each exposed a little differently."""
    frames = []
    for i, T in enumerate(T_true):
        sensor = synthetic.SensorOptions(read_noise=2.0, exposure=1.0 + 0.05 * i)
        frame = synthetic.render(
            synthetic.room(seed=1), CAMERA, T, width=WIDTH, height=HEIGHT, sensor=sensor, index=i
        )
        frames.append(frame)
    return frames


def centre_errors(T_cw: np.ndarray, T_true: np.ndarray) -> np.ndarray:
    """Distance of each camera centre from the truth, mm."""

    def centres(T: np.ndarray) -> np.ndarray:
        return -np.einsum("nji,nj->ni", T[:, :3, :3], T[:, :3, 3])

    return 1e3 * np.linalg.norm(centres(T_cw) - centres(T_true), axis=1)


def main() -> None:
    """Render, disturb, refine, compare."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("photometric.png"))
    out = parser.parse_args().out
    T_true = true_poses()
    frames = take_pictures(T_true)
    errors = np.random.default_rng(0).normal(0.0, 0.004, (NUM_IMAGES, 6)) * [1, 1, 1, 0.5, 0.5, 0.5]
    errors[0] = 0.0  # the first camera is held
    problem = pba.Problem.from_depth(
        [frame.image for frame in frames],
        [frame.depth for frame in frames],
        CAMERA,
        se3_exp(errors) @ T_true,
        600,
        depth_model=DepthModel(),
    )
    result = pba.adjust(problem)
    print(result.full_report())
    for name, T_cw in (("before", problem.T_cw), ("after", result.T_cw)):
        print(f"camera centres off by {centre_errors(T_cw, T_true).round(2)} mm {name}")
    result.figure_before_after(out)
    print(f"wrote {out}")


if __name__ == "__main__":
    main()
