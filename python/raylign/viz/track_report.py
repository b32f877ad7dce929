"""A folder that shows one run of the odometry."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from raylign import io
from raylign._build_info import build_info
from raylign._json import jsonable
from raylign._typing import F64, U8, AnyArray, PathLike
from raylign.depth import inverse_depth
from raylign.geometry import se3_inverse
from raylign.odometry import OdometryOptions, OdometryRun, Rectifier, has_pose
from raylign.tracking import AlignmentResult, Frame, Keyframe, align
from raylign.trajectory import Evaluation
from raylign.viz import style
from raylign.viz.page import Picture, html_page, markdown_page
from raylign.viz.tracking import plot_alignment, plot_normalised_residuals, plot_path, plot_run
from raylign.viz.trajectory import plot_trajectory

_MAX_PICTURED = 3  # frames whose residual maps are drawn
_POINT_STEP = 4  # every fourth pixel of a keyframe, each way, becomes a point of the cloud


def track_report(
    run: OdometryRun,
    sequence: io.RgbdSequence,
    directory: PathLike,
    *,
    options: OdometryOptions,
    errors: Evaluation | None = None,
    pictures: bool = True,
) -> list[Path]:
    """Write keyframes.ply and summary.json, and with `pictures` PNGs, index.html and index.md.

    Args:
        run: of `raylign.odometry.run` over `sequence`, at least one frame tracked.
        sequence: the frames of the run.
        directory: folder to write into; created, with its parents, when missing.
        options: what the run was made with.
        errors: of the trajectory against the truth, where there is one.
        pictures: draw.

    Returns:
        Paths of the files written.

    Raises:
        OSError: the folder cannot be made or written.
        FormatError: an image can no longer be read.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    frames = _Frames(run, sequence, options)
    written = [_write_points(frames, folder / "keyframes.ply")]
    rows = _headline(run, sequence, errors)
    pages = {"summary.json": _summary(run, sequence, options, errors)}
    if pictures:
        drawn = _draw(frames, run, sequence, errors)
        listed = [picture for picture, _ in drawn]
        written += [style.save(figure, folder / picture.file) for picture, figure in drawn]
        title = f"Tracking of {sequence.name}"
        pages["index.html"] = html_page(title, rows, listed)
        pages["index.md"] = markdown_page(title, rows, listed)
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
        written.append(folder / name)
    return written


class _Frames:
    """Rectified images and depth of the frames of a run."""

    def __init__(
        self, run: OdometryRun, sequence: io.RgbdSequence, options: OdometryOptions
    ) -> None:
        self.run = run
        self.options = options
        self._sequence = sequence
        self._rectifier: Rectifier | None = None

    def image(self, i: int) -> AnyArray:
        image = self._sequence[i].image
        return self._rectifier_of(image).image(image)

    def depth(self, i: int) -> AnyArray | None:
        depth = self._sequence[i].depth
        return None if depth is None else self._rectifier_of(depth).depth(depth)

    def tracking_frame(self, i: int) -> Frame:
        depth = self.depth(i)
        D, V = (None, None) if depth is None else inverse_depth(
            depth, model=self.options.depth_model
        )  # fmt: skip
        return Frame(self.image(i), self.run.camera, inverse_depth=D, variance=V)

    def _rectifier_of(self, image: AnyArray) -> Rectifier:
        if self._rectifier is None:
            height, width = image.shape[:2]
            self._rectifier = Rectifier(self._sequence.camera, width=width, height=height)
        return self._rectifier


def _write_points(frames: _Frames, path: Path) -> Path:
    clouds = [_keyframe_points(frames, i) for i in frames.run.keyframes]
    points = np.concatenate([cloud[0] for cloud in clouds])
    colors = np.concatenate([cloud[1] for cloud in clouds])
    io.write_ply_points(points, path, colors=colors)
    return path


def _keyframe_points(frames: _Frames, i: int) -> tuple[F64, U8]:
    depth = frames.depth(i)
    if depth is None:
        return np.empty((0, 3)), np.empty((0, 3), np.uint8)
    D, _ = inverse_depth(depth, model=frames.options.depth_model)
    v, u = np.mgrid[0 : D.shape[0] : _POINT_STEP, 0 : D.shape[1] : _POINT_STEP]
    known = D[v, u] > 0
    v, u = v[known], u[known]
    camera, T_wc = frames.run.camera, frames.run.results[i].T_wc
    Z = 1.0 / D[v, u].astype(np.float64)
    p_c = np.stack([(u - camera.cx) / camera.fx * Z, (v - camera.cy) / camera.fy * Z, Z], axis=1)
    image = frames.image(i)
    colors = image[v, u] if image.ndim == 3 else np.repeat(image[v, u, None], 3, axis=1)
    return p_c @ T_wc[:3, :3].T + T_wc[:3, 3], colors


def _draw(
    frames: _Frames, run: OdometryRun, sequence: io.RgbdSequence, errors: Evaluation | None
) -> list[tuple[Picture, Figure]]:
    caption = "From above and from the side."
    if errors is None:
        path = plot_path(run.trajectory, title=f"Path of {sequence.name}")
    else:
        caption += " Below: distance from the truth after alignment, error of the motion per frame."
        path = plot_trajectory(errors, title=f"Path of {sequence.name}")
    drawn = [(Picture("trajectory.png", "Path", caption), path)]
    caption = (
        "Share of the keyframe's points in view and in agreement, keyframes and losses; robust RMS "
        "of the normalised residual; time per frame without reading."
    )
    drawn.append((Picture("tracking.png", "Frames", caption), plot_run(run)))
    return drawn + _draw_alignments(frames, run)


def _draw_alignments(frames: _Frames, run: OdometryRun) -> list[tuple[Picture, Figure]]:
    drawn, normalised = [], []
    for i in _worth_a_look(run):
        result = _aligned_again(frames, i)
        maps: Any = result.maps
        normalised.append(maps.normalised_residual.ravel())
        name = f"frame {run.results[i].frame}"
        caption = f"Against keyframe {run.results[i].keyframe}, at the keyframe's pixels."
        picture = Picture(f"alignment-{run.results[i].frame:06d}.png", name.capitalize(), caption)
        drawn.append((picture, plot_alignment(frames.image(i), result, title=name)))
    if normalised:
        picture = Picture(
            "normalised_residuals.png",
            "Normalised residuals",
            "Of the frames above: N(0, 1) when the noise model is right, heavier tails where the "
            "scene breaks it.",
        )
        drawn.append((picture, plot_normalised_residuals(np.concatenate(normalised))))
    return drawn


def _worth_a_look(run: OdometryRun) -> list[int]:
    """The frame in the middle, the one that agrees least, the last."""
    aligned = [
        i for i, r in enumerate(run.results) if has_pose(r) and r.keyframe not in (-1, r.frame)
    ]
    if not aligned:
        return []
    worst = min(aligned, key=lambda i: run.results[i].alignment.good_ratio)
    return sorted({aligned[len(aligned) // 2], worst, aligned[-1]})[:_MAX_PICTURED]


def _aligned_again(frames: _Frames, i: int) -> AlignmentResult:
    """The alignment of a frame once more, from its result, with maps."""
    result = frames.run.results[i]
    host = result.keyframe - frames.run.results[0].frame
    keyframe = Keyframe.from_frame(frames.tracking_frame(host), options=frames.options.keyframe)
    return align(
        keyframe,
        frames.tracking_frame(i),
        T_init=se3_inverse(result.T_wc) @ frames.run.results[host].T_wc,
        options=frames.options.tracking,
        maps=True,
    )


def _headline(
    run: OdometryRun, sequence: io.RgbdSequence, errors: Evaluation | None
) -> list[tuple[str, str]]:
    milliseconds = 1e3 * run.times_s
    median, p95 = np.percentile(milliseconds, [50, 95])
    rows = [
        ("sequence", f"{sequence.name} ({sequence.format}), {len(run.results)} frames"),
        ("camera", str(run.camera)),
        ("tracked", f"{len(run.results) - run.num_lost} frames, {len(run.keyframes)} keyframes"),
        ("time per frame", f"median {median:.2f} ms, 95 % under {p95:.2f} ms"),
    ]
    if errors is None:
        return rows
    absolute, relative = errors.absolute.translation, errors.per_frame
    rows += [
        ("ATE", f"{1e3 * absolute.rmse:.2f} mm RMS, {1e3 * absolute.max:.2f} mm at most"),
        (
            "RPE per frame",
            f"{1e3 * relative.translation.rmse:.2f} mm, "
            f"{np.degrees(relative.rotation.rmse):.3f} deg RMS",
        ),
    ]
    return rows


def _summary(
    run: OdometryRun,
    sequence: io.RgbdSequence,
    options: OdometryOptions,
    errors: Evaluation | None,
) -> str:
    record = {
        "sequence": sequence.name,
        "format": sequence.format,
        "camera": str(run.camera),
        "reader": vars(sequence.report),
        "num_frames": len(run.results),
        "num_lost": run.num_lost,
        "was_interrupted": run.was_interrupted,
        "keyframes": [run.results[i].frame for i in run.keyframes],
        "median_time_s": float(np.median(run.times_s)),
        "errors": None if errors is None else errors.to_dict(),
        "options": options,
        "build": build_info(),
    }
    return json.dumps(jsonable(record), indent=2, allow_nan=False) + "\n"
