"""A small rendered scene for the tests of the photometric façade, command and pictures."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from raylign import depth, geometry, image, io, photometric, synthetic
from raylign.camera import PinholeCamera
from sequence_trees import save_image

CAMERA = PinholeCamera(140.0, 140.0, 79.5, 59.5)


class SmallScene(NamedTuple):
    """Images with depth, true poses, and poses that are a little off."""

    images: list[np.ndarray]
    depths: list[np.ndarray]
    T_true: np.ndarray
    T_start: np.ndarray

    def problem(self, **options) -> photometric.Problem:
        """Points from depth, whose priors hold the scale."""
        options = {"n_points": 160, "depth_model": depth.DepthModel(), **options}
        return photometric.Problem.from_depth(
            self.images, self.depths, CAMERA, self.T_start, **options
        )

    def truth_problem(self) -> photometric.Problem:
        """The same points where they are, images without noise."""
        scene, start = _scene(), self.problem()
        frames = [synthetic.render(scene, CAMERA, T, width=160, height=120) for T in self.T_true]
        hosts, uv = start._arrays["hosts"], start._arrays["host_uv"].astype(int)
        rays, _ = CAMERA.unproject(uv.astype(float))
        z = np.array([frames[h].depth[v, u] for h, (u, v) in zip(hosts, uv, strict=True)])
        T_wh = geometry.se3_inverse(self.T_true)[hosts]
        p_h = rays * (z / rays[:, 2])[:, None]
        points = np.einsum("nij,nj->ni", T_wh[:, :3, :3], p_h) + T_wh[:, :3, 3]
        return photometric.Problem(
            [frame.irradiance.astype(np.float32) for frame in frames],
            CAMERA,
            self.T_true,
            points,
            host=hosts,
            host_uv=uv,
            normals=start._arrays["normals"],
            depth_sigma=start._arrays["depth_sigmas"],
        )

    def write(self, folder: Path) -> None:
        """The files that `raylign photometric` reads; patches from image 0, row 0 of points."""
        problem = self.problem()
        uv, _ = problem.project(0, T_cw=self.T_true)
        offsets = photometric.PatchPattern.parse("4x4").offsets
        values, _, valid = image.sample(self.images[0], uv[:, None] + offsets)
        inside = valid.all(axis=1)
        io.write_patch_points(problem.points[inside], folder / "points.txt", patches=values[inside])
        io.write_poses(self.T_start, folder / "poses.txt")
        for i, picture in enumerate(self.images):
            save_image(folder / f"{i}.png", picture)


def small_scene(num_images: int = 3, off: float = 0.004) -> SmallScene:
    """Images of a textured wall at 2 m, not flat, noise of two grey levels."""
    scene = _scene()
    sensor = synthetic.SensorOptions(read_noise=2.0)
    motions = [[0.06 * i, 0.02 * (i % 2), 0.0, 0.0, -0.02 * i, 0.01 * i] for i in range(num_images)]
    T_true = geometry.se3_exp(motions)
    frames = [
        synthetic.render(scene, CAMERA, T, width=160, height=120, sensor=sensor, index=i)
        for i, T in enumerate(T_true)
    ]
    rng = np.random.default_rng(1)
    errors = rng.normal(0.0, off, (num_images, 6)) * [1, 1, 1, 0.5, 0.5, 0.5]
    errors[0] = 0.0
    T_start = geometry.se3_exp(errors) @ T_true
    return SmallScene(
        [frame.image for frame in frames],
        [frame.depth.astype(np.float32) for frame in frames],
        T_true,
        T_start,
    )


def _scene() -> synthetic.Scene:
    return synthetic.height_field(seed=5, amplitude=0.1)


def centres(T_cw: np.ndarray) -> np.ndarray:
    """(M, 3) camera centres in the world."""
    return -np.einsum("nji,nj->ni", T_cw[:, :3, :3], T_cw[:, :3, 3])
