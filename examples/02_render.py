"""Take pictures of scenes with known truth: image, depth and normals.

    python examples/02_render.py [--out PICTURE]

Draws three scenes and checks the truth of one of them: the depth of a view, carried into another
view, is the depth there.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from raylign import synthetic
from raylign.camera import PinholeCamera
from raylign.geometry import se3_exp

WIDTH, HEIGHT = 320, 240
CAMERA = PinholeCamera(262.0, 262.0, 159.5, 119.5)
SCENES = {
    "boxes": synthetic.boxes(seed=4),
    "sphere": synthetic.sphere(seed=1),
    "height_field": synthetic.height_field(seed=2, amplitude=0.2),
}


def draw(frames: dict[str, synthetic.Frame]) -> Figure:
    """One row per scene."""
    figure = Figure(figsize=(9.0, 2.35 * len(frames)), layout="constrained")
    grid = figure.subplots(len(frames), 3, squeeze=False)
    for axes, (name, frame) in zip(grid, frames.items(), strict=True):
        axes[0].imshow(frame.image, cmap="gray", vmin=0, vmax=255)
        picture = axes[1].imshow(frame.depth, cmap="viridis")
        figure.colorbar(picture, ax=axes[1], label="depth (m)")
        axes[2].imshow(0.5 * (1.0 - frame.normal))
        for ax, what in zip(axes, ("image", "depth", "normals"), strict=True):
            ax.set_title(f"{name}: {what}", fontsize=9)
            ax.set_axis_off()
    return figure


def depth_error(scene: synthetic.Scene, motion: list[float]) -> float:
    """Largest difference (m) between depth carried over and depth rendered, where both see it."""
    here = synthetic.render(scene, CAMERA, np.eye(4), width=WIDTH, height=HEIGHT)
    v, u = np.mgrid[:HEIGHT:7, :WIDTH:7]
    rays, _ = CAMERA.unproject(np.stack([u, v], axis=-1).astype(float))
    points = rays * (here.depth[::7, ::7] / rays[..., 2])[..., None]
    T = se3_exp(motion)
    moved = points @ T[:3, :3].T + T[:3, 3]
    uv, _ = CAMERA.project(moved)
    errors = []
    for at, z in zip(uv.reshape(-1, 2), moved.reshape(-1, 3)[:, 2], strict=True):
        pixel = PinholeCamera(CAMERA.fx, CAMERA.fy, CAMERA.cx - at[0], CAMERA.cy - at[1])
        there = synthetic.render(scene, pixel, T, width=1, height=1).depth[0, 0]
        if there > z - 1e-3:  # else something stands before the point
            errors.append(abs(there - z))
    return max(errors)


def main() -> None:
    """Render, check, draw."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("rendered-scenes.png"))
    out = parser.parse_args().out
    frames = {
        name: synthetic.render(scene, CAMERA, np.eye(4), width=WIDTH, height=HEIGHT)
        for name, scene in SCENES.items()
    }
    draw(frames).savefig(out, dpi=80)
    print(f"wrote {out}")
    error = depth_error(SCENES["boxes"], [0.1, -0.05, 0.1, 0.02, 0.05, 0.0])
    print(f"depth carried into another view is off by at most {error:.1e} m")


if __name__ == "__main__":
    main()
