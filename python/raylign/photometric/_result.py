"""What `adjust` found, and how it leaves the program."""

from typing import Any

import numpy as np

from raylign import _core, geometry, io
from raylign._core import BundleConfig, EdgeStatus, PhotometricOptions, PointStatus
from raylign._typing import F64, U8, AnyArray, PathLike
from raylign.errors import OptionsError
from raylign.photometric._problem import Problem
from raylign.scene import BalProblem

_UNKNOWN = (150, 150, 150)
_STATUS_COLORS = {
    PointStatus.OK: (31, 122, 140),
    PointStatus.FEW_VIEWS: (224, 160, 48),
    PointStatus.OUT_OF_VIEW: _UNKNOWN,
    PointStatus.OCCLUDED: (120, 80, 160),
    PointStatus.LOW_TEXTURE: (200, 200, 120),
    PointStatus.SATURATED: (240, 240, 240),
    PointStatus.DIVERGED: (200, 60, 40),
    PointStatus.FIXED: (40, 40, 40),
}
# viridis at 0, 1/4, 1/2, 3/4, 1: matplotlib is not needed for this
_RAMP = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], float)


class PhotometricResult:
    """Refined state, statistics and verdict of `adjust`.

    Attributes (all arrays are copies):
        problem, options, config: what was adjusted, and how.
        T_cw: (M, 4, 4), points (N, 3), brightness (M, 2) a, b, intrinsics (1 or M, 4): the refined
            state; the start, bit by bit, when `accepted` is false and `force` was not set.
        accepted, reason, num_hold_out, hold_out_cost_before, hold_out_cost_after: the verdict of
            points that the solve did not see.
        messages: what the user should know, a list of sentences.
        point_status: (N,) uint8 of `PointStatus`; edge_status (E,) of `EdgeStatus`, with edge_image
            and edge_point (E,).
        edge_rms_before, edge_rms_after (E,), point_rms_before, point_rms_after (N,),
        image_rms_before, image_rms_after (M,): RMS residual, grey levels; NaN: none.
        shift_px: (M,) median motion of the projections.
        sigma, nu, threshold: the fitted law, grey levels.
        presmooth: σ px of the Gaussian that the images were smoothed with.
        noise_ratio: κ of the residuals' scale √((1 + κ) / (1 + κ e^{2 (a_j − a_h)})); 0: none.
        hosts, host_uv, patches, normals: what the images were compared with.
        gauge: what anchors the result, in words.
        rounds: structured array, one row per inner solve; summary: `Summary`, all iterations.
        pose_covariance: (6M, 6M) of ξ = [υ; ω] per image, T_cw = exp(ξ) T_estimate.
        point_covariances: (N, 3, 3).
    """

    def __init__(
        self,
        problem: Problem,
        options: PhotometricOptions,
        config: BundleConfig,
        core: _core.PhotometricResult,
    ) -> None:
        self.problem = problem
        self.options = options
        self.config = config
        self._core = core

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._core, name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(n for n in dir(self._core) if n[0] != "_")})

    def __repr__(self) -> str:
        return f"<PhotometricResult: {self.brief_report()}>"

    def point_counts(self) -> dict[str, int]:
        """How many points have each status, lower-case names, those that occur."""
        return _counts(self._core.point_status, PointStatus)

    def edge_counts(self) -> dict[str, int]:
        """How many views have each status, lower-case names, those that occur."""
        return _counts(self._core.edge_status, EdgeStatus)

    def residual_median(self) -> tuple[float, float]:
        """Median over the OK views of the RMS residual, grey levels, before and after."""
        ok = self._core.edge_status == EdgeStatus.OK.value
        if not ok.any():
            return float("nan"), float("nan")
        return (
            float(np.nanmedian(self._core.edge_rms_before[ok])),
            float(np.nanmedian(self._core.edge_rms_after[ok])),
        )

    def brief_report(self) -> str:
        """One line: verdict, residual, motion, time."""
        r = self._core
        before, after = self.residual_median()
        verdict = "accepted" if r.accepted else f"not accepted: {r.reason}"
        if self.options.force and not r.accepted:
            verdict = f"kept by force, {verdict}"
        return (
            f"{verdict}; median residual {before:.3g} -> {after:.3g} grey levels, median shift "
            f"{np.nanmedian(r.shift_px):.2f} px, {r.summary.total_time_s:.2f} s"
        )

    def full_report(self) -> str:
        """Several lines for people."""
        r = self._core
        points = ", ".join(f"{n} {name}" for name, n in self.point_counts().items())
        views = ", ".join(f"{n} {name}" for name, n in self.edge_counts().items())
        law = f"sigma {r.sigma:.3g} grey levels" + (f", nu {r.nu:.3g}" if r.nu > 0 else "")
        lines = [
            self.brief_report(),
            f"verdict: {r.reason}",
            f"points: {points}",
            f"views: {views}",
            f"noise: {law}; loss threshold {r.threshold:.3g}",
            f"gauge: {r.gauge}",
            "image  RMS before  after  shift px        a        b",
        ]
        rows = zip(r.image_rms_before, r.image_rms_after, r.shift_px, r.brightness, strict=True)
        lines += [
            f"{i:5d} {before:11.2f} {after:6.2f} {shift:9.2f} {ab[0]:8.3f} {ab[1]:8.2f}"
            for i, (before, after, shift, ab) in enumerate(rows)
        ]
        return "\n".join([*lines, *r.messages])

    def write_text(self, points: PathLike, poses: PathLike) -> None:
        """Write `points.txt` and `poses.txt` (T_cw) as `Problem.from_text` reads them.

        Args:
            points: target of the refined points with the patches they were compared with.
            poses: target of the refined poses.

        Raises:
            FormatError: a target cannot be written.
        """
        io.write_patch_points(self._core.points, points, patches=self._core.patches)
        io.write_poses(self._core.T_cw, poses, timestamps=self.problem.timestamps)

    def write_ply(
        self, path: PathLike, *, color: str = "image", cameras: bool = True, start: bool = False
    ) -> io.PlySummary:
        """Write the point cloud for viewers.

        Args:
            path: target, `.ply`.
            color: "image": as the images show it; "error": RMS residual, dark small, bright large;
                "sigma": longest half axis of the covariance, log scale (needs
                `options.covariance=CovarianceScope.ALL`); "status": `PointStatus`.
            cameras: draw them as frusta.
            start: the start instead of the result.

        Returns:
            io.PlySummary: what was written and left out.

        Raises:
            OptionsError: an unknown colour, or no covariance to show.
            FormatError: the target cannot be written.
        """
        rgb = self.point_colors(color)
        state = self.problem if start else self._core
        scene = cameras_as_bal(self.problem, state.T_cw, state.points)
        return io.write_ply(scene, path, colors=rgb, cameras=cameras)

    def point_colors(self, color: str = "image") -> U8:
        """(N, 3) RGB of the points, as `write_ply` paints them."""
        if color == "image":
            return _image_colors(self)
        if color == "status":
            palette = np.array([_STATUS_COLORS[status] for status in PointStatus], np.uint8)
            return palette[self._core.point_status]
        if color == "error":
            return _ramp(self._core.point_rms_after)
        if color != "sigma":
            raise OptionsError(f"color must be image, error, sigma or status, got {color!r}")
        covariances = self._core.point_covariances
        if len(covariances) == 0:
            raise OptionsError("color='sigma' needs options.covariance=CovarianceScope.ALL")
        return _ramp(np.log(point_sigmas(covariances)))

    def figure_before_after(self, path: PathLike) -> None:
        """Draw points by error in each image, patches, and the residuals' law; needs matplotlib.

        Args:
            path: PNG to write. `raylign.viz.photometric` has the parts.
        """
        from importlib import import_module  # viz is above this layer, and loads matplotlib

        import_module("raylign.viz.photometric").write_before_after(self, path)


def point_sigmas(covariances: F64) -> F64:
    """(N,) longest half axis of each (3, 3) covariance; NaN where it has none."""
    known = np.isfinite(covariances).all(axis=(1, 2))
    sigma = np.full(len(covariances), np.nan)
    sigma[known] = np.sqrt(np.maximum(np.linalg.eigvalsh(covariances[known])[:, -1], 0.0))
    return sigma


def cameras_as_bal(problem: Problem, T_cw: F64, points: F64) -> BalProblem:
    """Poses and points for the PLY writer and the pictures, which know BAL's cameras."""
    flip = np.diag([1.0, -1.0, -1.0])
    R = flip @ T_cw[:, :3, :3]
    cameras = np.zeros((problem.num_images, 9))
    cameras[:, :3] = geometry.so3_log(np.ascontiguousarray(R))
    cameras[:, 3:6] = T_cw[:, :3, 3] @ flip
    corners = []  # of the images: how wide the frusta are drawn
    for i in range(problem.num_images):
        camera, (height, width) = problem.camera(i), problem.image(i).shape
        cameras[i, 6] = camera.fx
        x = np.array([0.0, width - 1.0])[[0, 1, 0, 1]] - camera.cx
        y = np.array([0.0, height - 1.0])[[0, 0, 1, 1]] - camera.cy
        corners.append(np.stack([x, -y * camera.fx / camera.fy], axis=1))
    index = np.repeat(np.arange(problem.num_images, dtype=np.int32), 4)
    return BalProblem(
        cameras,
        np.ascontiguousarray(points),
        index,
        np.zeros_like(index),
        np.ascontiguousarray(np.concatenate(corners)),
    )


def _counts(values: AnyArray, kind: Any) -> dict[str, int]:
    numbers = np.bincount(values, minlength=len(kind))
    return {
        status.name.lower(): int(numbers[status.value]) for status in kind if numbers[status.value]
    }


def _ramp(values: F64) -> U8:
    """Colours from the 2nd to the 98th percentile; grey where there is no value."""
    rgb = np.tile(np.array(_UNKNOWN, np.uint8), (len(values), 1))
    known = np.isfinite(values)
    if known.any():
        low, high = np.percentile(values[known], [2, 98])
        x = np.clip((values[known] - low) / max(high - low, 1e-12), 0.0, 1.0) * (len(_RAMP) - 1)
        mixed = [np.interp(x, np.arange(len(_RAMP)), _RAMP[:, c]) for c in range(3)]
        rgb[known] = np.rint(np.stack(mixed, axis=1)).astype(np.uint8)
    return rgb


def _image_colors(result: PhotometricResult) -> U8:
    """From the host where there is one, else from the first image that sees the point."""
    problem, core = result.problem, result._core
    rgb = np.tile(np.array(_UNKNOWN, np.uint8), (problem.num_points, 1))
    source = np.array(core.hosts)
    ok = core.edge_status == EdgeStatus.OK.value
    point, first = np.unique(core.edge_point[ok], return_index=True)
    seen = np.full(problem.num_points, -1)
    seen[point] = core.edge_image[ok][first]
    source = np.where(source >= 0, source, seen)
    for i in range(problem.num_images):
        mine = np.flatnonzero(source == i)
        uv, _ = problem.project(i, T_cw=core.T_cw, points=core.points[mine])
        grey, color = problem.image(i), problem.color_image(i)
        inside = np.isfinite(uv).all(axis=1)
        at = np.rint(uv[inside]).astype(int)
        at = np.clip(at, 0, [grey.shape[1] - 1, grey.shape[0] - 1])
        values = grey[at[:, 1], at[:, 0], None] if color is None else color[at[:, 1], at[:, 0]]
        rgb[mine[inside]] = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return rgb
