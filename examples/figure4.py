"""Figure 4 of LSD-SLAM on exact images: what noise of the depth costs under three motions.

    python examples/figure4.py [-o figure4.png]

A wall with gradients in all directions is seen by a keyframe and by three frames: turned, moved
along z, moved along x. For each frame the map S = 2 sigma_I^2 / sigma_r^2 is taken from
`raylign.tracking.align` at the true pose; below it stands the histogram of the residual before and
after normalisation, with noise in both images and in the depth. docs/theory/figure4.md explains.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from raylign import synthetic
from raylign.camera import PinholeCamera
from raylign.geometry import se3_exp, se3_inverse
from raylign.tracking import (
    AffineMode,
    AffineOptions,
    AlignmentMaps,
    Keyframe,
    KeyframeOptions,
    NoiseModel,
    TrackingOptions,
    align,
)
from raylign.viz import style

Map = npt.NDArray[np.float64]
Paint = Callable[[Map, Map], Map]

DISTANCE = 2.0  # of the wall, m
SIGMA_D = 0.01  # of the inverse depth, 1/m: 2 % of it
SIGMA_I = 8.0**0.5  # grey levels: 2 sigma_I^2 = 16, the value of LSD-SLAM's program
MOTIONS = {  # T_th
    "rotation": se3_exp([0, 0, 0, 0, 0, 0.15]) @ se3_exp([0, 0, 0, 0, 0.1, 0]),
    "z translation": se3_exp([0, 0, 0.1 * DISTANCE, 0, 0, 0]),
    "x translation": se3_exp([0.1 * DISTANCE, 0, 0, 0, 0, 0]),
}
WHAT_IT_SHOWS = {
    "rotation": "the same weight everywhere",
    "z translation": "rings darken outwards, no spoke",
    "x translation": "dark by the gradient in x alone",
}
NO_DEPTH = "#9ca3af"
COLORS = mpl.colormaps["magma"].with_extremes(bad=NO_DEPTH)
DPI = 100


@dataclass(frozen=True)
class View:
    """A picture of the wall: grey (H, W) float32 and depth (H, W) float64 in m, both exact."""

    image: npt.NDArray[np.float32]
    depth: Map


def camera_of(width: int) -> tuple[PinholeCamera, int, int]:
    """Camera, width and height, 4:3 and odd: the optical axis goes through a pixel's centre."""
    width, height = width | 1, (3 * width // 4) | 1
    return PinholeCamera(0.8 * width, 0.8 * width, width // 2, height // 2), width, height


def dartboard(x: Map, y: Map) -> Map:
    """Grey of the wall at (x, y) m: rings (radial gradients) and spokes (tangential ones).

    The edges (m) are tanh steps of one width all over, so that only their direction tells them
    apart.
    """
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    ring, sectors, edge = 0.24, 16, 0.018
    to_ring = ring / np.pi * np.sin(np.pi * radius / ring)  # distance to the next edge, signed
    to_spoke = radius * 2.0 / sectors * np.sin(0.5 * sectors * angle)
    return 128.0 - 80.0 * np.tanh(to_ring / edge) * np.tanh(to_spoke / edge)


def view(T_cw: Map, *, width: int, paint: Paint = dartboard) -> View:
    """The wall z = DISTANCE as a camera sees it.

    The renderer gives the depth; the paint is evaluated where the rays through the pixel centres
    land, so two views agree on a point of the wall to rounding.
    """
    camera, width, height = camera_of(width)
    wall = synthetic.plane(slant_deg=0.0, distance=DISTANCE)
    depth = synthetic.render(wall, camera, T_cw, width=width, height=height).depth
    v, u = np.mgrid[:height, :width].astype(np.float64)
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)])
    T_wc = se3_inverse(T_cw)
    x, y, _ = np.einsum("ij,jvu->ivu", T_wc[:3, :3], rays * depth) + T_wc[:3, 3, None, None]
    return View(paint(x, y).astype(np.float32), depth)


def maps_at(
    keyframe: Keyframe,
    image: npt.NDArray[np.float32],
    T_th: Map,
    *,
    noise_model: NoiseModel = NoiseModel.CONSTANT,
) -> AlignmentMaps:
    """Residuals and their sigma at the full image, with the pose as it is: no iterations."""
    options = TrackingOptions(
        noise_model=noise_model,
        sigma_intensity=SIGMA_I,
        affine=AffineOptions(mode=AffineMode.NONE),
        finest_level=0,
        coarsest_level=0,
        level_iterations=[0],
    )
    return align(keyframe, image, T_init=T_th, options=options, maps=True).maps


def normalisation(
    here: View, there: View, T_th: Map, *, sigma_D: float = SIGMA_D, min_gradient: float = 4.0
) -> Map:
    """S = 2 sigma_I^2 / sigma_r^2 in (0, 1] at the keyframe's pixels, NaN outside Omega_D."""
    camera, _, _ = camera_of(here.image.shape[1])
    keyframe = Keyframe(
        here.image,
        camera,
        inverse_depth=(1.0 / here.depth).astype(np.float32),
        variance=sigma_D**2,
        options=KeyframeOptions(min_gradient=min_gradient),
    )
    sigma_r = maps_at(keyframe, there.image, T_th).sigma.astype(np.float64)
    return 2.0 * SIGMA_I**2 / sigma_r**2


def residuals(here: View, there: View, T_th: Map, *, seed: int = 0) -> tuple[Map, Map]:
    """r over its sigma without and with the depth's share, with noise in images and depth.

    The images are noisy, so interpolation matters: the noise model is the exact one.
    """
    camera, width, height = camera_of(here.image.shape[1])
    noise = [
        synthetic.noise_field(width=width, height=height, seed=seed, index=k) for k in range(3)
    ]
    host, target = (
        (one.image + SIGMA_I * noise[k]).astype(np.float32) for k, one in enumerate((here, there))
    )
    D = (1.0 / here.depth + SIGMA_D * noise[2]).astype(np.float32)
    pair = []
    for variance in (1e-12, SIGMA_D**2):
        keyframe = Keyframe(
            host,
            camera,
            inverse_depth=D,
            variance=variance,
            options=KeyframeOptions(min_gradient=12.0),  # over the noise of the gradient
        )
        maps = maps_at(keyframe, target, T_th, noise_model=NoiseModel.EXACT)
        pair.append(maps.normalised_residual[maps.mask].astype(np.float64))
    return pair[0], pair[1]


def show_image(axes: Axes, image: npt.NDArray[np.float32], title: str) -> None:
    axes.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.set_title(title)
    axes.set_axis_off()


def show_map(axes: Axes, S: Map, title: str) -> None:
    axes.imshow(S, cmap=COLORS, vmin=0.0, vmax=1.0, interpolation="nearest")
    axes.set_title(title, fontweight="normal", fontsize=9.0)
    axes.set_axis_off()


def show_histogram(axes: Axes, before: Map, after: Map) -> None:
    edges = np.linspace(-8.0, 8.0, 65)
    middle = 0.5 * (edges[1:] + edges[:-1])
    normal = np.exp(-0.5 * middle**2) / np.sqrt(2.0 * np.pi)
    axes.plot(middle, normal, ":", color=style.CAMERA)
    for values, color in ((before, style.BEFORE), (after, style.AFTER)):
        counts, _ = np.histogram(values, edges)
        axes.stairs(counts / (len(values) * np.diff(edges)), edges, color=color, linewidth=1.4)
    axes.set(yscale="log", ylim=(1e-4, 1.0), xlim=(-8.0, 8.0), xlabel="residual over its σ")
    widths = f"standard deviation {before.std():.2f} → {after.std():.2f}"
    axes.set_title(widths, fontweight="normal", fontsize=9.0)


def show_keys(scale: Axes, lines: Axes, figure: Figure) -> None:
    """Under the keyframe: what the colours of the maps mean, and the lines of the histograms."""
    for axes in (scale, lines):
        axes.set_axis_off()
    bar = scale.inset_axes((0.0, 0.42, 1.0, 0.09))
    mappable = mpl.cm.ScalarMappable(norm=mpl.colors.Normalize(0.0, 1.0), cmap=COLORS)
    figure.colorbar(mappable, cax=bar, orientation="horizontal")
    text = {"transform": scale.transAxes, "fontsize": 9.0}
    scale.text(0.0, 0.72, r"$S = 2\sigma_I^2\,/\,\sigma_r^2$ at the keyframe's pixels", **text)
    scale.text(0.0, 0.57, "dark: depth noise takes weight away", color=style.MUTED, **text)
    scale.add_patch(mpl.patches.Rectangle((0.0, 0.08), 0.09, 0.11, color=NO_DEPTH, clip_on=False))
    scale.text(0.13, 0.1, "no gradient, or out of view", color=style.MUTED, **text)
    keys = {
        r"$r$ over intensity noise alone": {"color": style.BEFORE},
        r"$r\,/\,\sigma_r$, with the depth's part": {"color": style.AFTER},
        "N(0, 1)": {"color": style.CAMERA, "linestyle": ":"},
    }
    handles = [mpl.lines.Line2D([], [], label=label, **line) for label, line in keys.items()]
    lines.legend(handles=handles, loc="center left", borderaxespad=0.0)


def draw(width: int) -> Figure:
    """Images, maps and histograms, one column per motion."""
    here = view(np.eye(4), width=width)
    figure = style.new_figure(
        10.4, 6.5, "Statistical normalisation", "figure 4 of LSD-SLAM, on exact images"
    )
    grid = figure.subplots(3, 4, height_ratios=[1.0, 1.0, 0.75])
    for axes in grid[2, 2:]:
        axes.sharey(grid[2, 1])
        axes.tick_params(labelleft=False)
    show_image(grid[0, 0], here.image, "(a) keyframe")
    show_keys(grid[1, 0], grid[2, 0], figure)
    for column, letter, (name, T_th) in zip(grid.T[1:], "bcd", MOTIONS.items(), strict=True):
        there = view(T_th, width=width)
        S = normalisation(here, there, T_th)
        show_image(column[0], there.image, f"({letter}) {name}")
        show_map(column[1], S, WHAT_IT_SHOWS[name])
        show_histogram(column[2], *residuals(here, there, T_th))
        print(f"{name}: S from {np.nanmin(S):.3f} to {np.nanmax(S):.3f}")
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("figure4.png"))
    parser.add_argument("--width", type=int, default=480, help="of the images, px")
    arguments = parser.parse_args()
    with mpl.rc_context(style.RC):
        draw(arguments.width).savefig(arguments.output, dpi=DPI, metadata={"Software": "raylign"})
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
