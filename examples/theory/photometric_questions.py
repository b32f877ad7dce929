"""Four questions on direct bundle adjustment: inverse depth, patch size, features, threshold.

    python examples/theory/photometric_questions.py

Five cameras look into a rendered room (photometric_room.py) whose geometry is exact; a second scene
is a wall far away.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import photometric_room as scenes
from common import LINES, Result, print_table, run
from photometric_room import CAMERA, FOCAL, HELD, HOST, NUM_CAMERAS, View
from raylign import bundle, synthetic
from raylign.bundle import BundleConfig, BundleOptions, LmOptions
from raylign.geometry import se3_exp, se3_inverse
from raylign.photometric import (
    BrightnessOptions,
    NoiseOptions,
    PatchPattern,
    PhotometricResult,
    VisibilityOptions,
)
from raylign.robust import Loss
from raylign.scene import BundleProblem, CameraModel
from raylign.viz import style

OUTLIERS = 0.2  # share of the points at a wrong depth
START_PX = 1.5  # median shift of the projections at the start
PATTERNS = ("3x3", "4x4", "5x5", "spread8")
SHIFTS = (0.5, 1.5, 3.0, 6.0, 12.0, 20.0)  # px
THRESHOLDS = (0.1, 0.2, 0.4, 0.7, 1.345, 2.5, 5.0, 10.0, 30.0)  # sigma


def rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


# --- 1. inverse depth ---


def far_wall(distance: float) -> View:
    """Cameras on a line of length 1, their baseline, in front of a wall; the same texture in px."""
    # Rolled against each other: else all points of the wall are read at the same fraction of a
    # pixel, and interpolation, which smooths noise most half-way, draws all of them the same way.
    roll = np.radians(np.linspace(-4.0, 4.0, NUM_CAMERAS))
    T_wc = se3_exp(np.column_stack([np.zeros((NUM_CAMERAS, 5)), roll]))
    T_wc[:, 0, 3] = np.linspace(-0.5, 0.5, NUM_CAMERAS)
    T_cw = se3_inverse(T_wc)
    texture = synthetic.TextureOptions(
        min_wavelength=5.0 * distance / FOCAL, max_wavelength=50.0 * distance / FOCAL
    )
    return scenes.look(
        synthetic.plane(seed=3, slant_deg=0.0, distance=distance, texture=texture), T_cw
    )


def measure_depths(quick: bool) -> list[Result]:
    """Depth and inverse depth of points seen by known cameras: their law, and the way there."""
    rows = []
    for distance in (20.0, 500.0):
        view = far_wall(distance)
        ratios = []
        for seed in range(1 if quick else 4):
            images = scenes.expose(view, seed)
            found = estimate_depths(view, images, "inverse_depth", view.depth)[0]
            ratios += (found / distance)[np.isfinite(found)].tolist()
        images = scenes.expose(view, 0)
        costs = {}
        for kind in ("xyz", "inverse_depth"):
            result = estimate_depths(view, images, kind, 2.0 * view.depth)[1]
            costs[kind] = result.summary.iterations["cost"].tolist()
        z, rho = np.array(ratios), 1.0 / np.array(ratios)
        rows.append(
            {
                "baselines": distance,
                "z": z.tolist(),
                "rho": rho.tolist(),
                "asymmetry_z": asymmetry(z),
                "asymmetry_rho": asymmetry(rho),
                "sigma_rho": float(np.std(rho)),
                "mean_z": float(np.mean(z)),
                "mean_rho": float(np.mean(rho)),
                "costs": costs,
            }
        )
    print_table(
        ("baselines", "std of rho", "mean z", "mean rho", "asymmetry z", "of rho"),
        (
            [
                r[k]
                for k in (
                    "baselines",
                    "sigma_rho",
                    "mean_z",
                    "mean_rho",
                    "asymmetry_z",
                    "asymmetry_rho",
                )
            ]
            for r in rows
        ),
    )
    return rows


def estimate_depths(
    view: View, images: list[np.ndarray], kind: str, depth: np.ndarray
) -> tuple[np.ndarray, PhotometricResult]:
    everything = BundleConfig(gauge="free", constant_cameras=list(range(NUM_CAMERAS)))
    result = scenes.refine(
        view,
        images,
        view.T_cw,
        depth,
        config=everything,
        point_parametrization=kind,
        refine_poses=False,
        num_levels=1,
        max_num_rounds=1,
        hold_out=0,
        noise=NoiseOptions(scale=3.0, nu=10.0),
        brightness=BrightnessOptions(model="none"),
        visibility=VisibilityOptions(rule="all"),
        lm=LmOptions(max_num_iterations=40, function_tolerance=1e-12),
    )
    T = view.T_cw[HOST]
    return (result.points @ T[:3, :3].T + T[:3, 3])[:, 2], result


def asymmetry(x: np.ndarray) -> float:
    """How much farther the 95th percentile is from the median than the 5th; in -1..1."""
    low, middle, high = np.percentile(x, [5.0, 50.0, 95.0])
    return float((high + low - 2.0 * middle) / (high - low))


# --- 2. patch size ---


def measure_patterns(quick: bool) -> list[Result]:
    view = scenes.room()
    seeds = range(1 if quick else 8)
    pair = PatchPattern([[-1.0, -1.0], [-1.0, 0.0], [0.0, -1.0], [0.0, 0.0]])  # 2x2
    patterns = [pair, *(PatchPattern.parse(name) for name in PATTERNS)]
    rows = []
    for pattern in patterns:
        errors, times, motions = [], [], []
        for seed in seeds:
            result = scenes.refine(
                view,
                scenes.expose(view, seed),
                *scenes.start(view, START_PX, seed),
                pattern=pattern,
            )
            errors.append(scenes.center_rms(view, result.T_cw))
            steps = result.summary.iterations
            times.append(result.summary.total_time_s / max(len(steps) - 1, 1))
            motions.append(reprojection_px(view, result))
        rows.append(
            {
                "pattern": pattern.name,
                "pixels": len(pattern.offsets),
                "error_mm": rms(errors),
                "error_px": float(np.median(motions)),
                "iteration_s": float(np.median(times)),
            }
        )
    print_table(
        ("pattern", "pixels", "centres, mm", "points, px", "s per iteration"),
        (r.values() for r in rows),
    )
    return rows


def reprojection_px(view: View, result: PhotometricResult) -> float:
    """Median distance of the projections of the result from the true ones."""
    found = scenes.project(result.T_cw, result.points)
    true = scenes.project(view.T_cw, view.points)
    return float(np.median(np.linalg.norm(found - true, axis=-1)))


# --- 3. features or grey values ---


def measure_basin(quick: bool) -> list[Result]:
    """Errors of direct and feature-based adjustment against the quality of the start."""
    view = scenes.room()
    rows = []
    for seed in range(1 if quick else 4):
        images = scenes.expose(view, seed)
        tracks = sift_tracks(images)
        for px in SHIFTS[1::2] if quick else SHIFTS:
            T_cw, depth = scenes.start(view, px, seed)
            one, many = (
                scenes.refine(view, images, T_cw, depth, num_levels=levels) for levels in (1, 4)
            )
            features = refine_features(view, T_cw, depth, tracks)
            rows.append(
                {
                    "start_px": px,
                    "start_mm": scenes.center_rms(view, T_cw),
                    "one_level": scenes.center_rms(view, one.T_cw),
                    "four_levels": scenes.center_rms(view, many.T_cw),
                    "features": scenes.center_rms(view, features),
                }
            )
    print_table(rows[0], (r.values() for r in rows))
    return rows


def sift_tracks(images: Sequence[np.ndarray]) -> list[dict[int, np.ndarray]]:
    """Per keypoint of the host: pixel (u, v) in the host and in each image that shows it."""
    sift = cv2.SIFT_create(contrastThreshold=0.02)
    found = [sift.detectAndCompute(image, None) for image in images]
    pixels = [np.array([k.pt for k in keypoints]) for keypoints, _ in found]
    tracks: list[dict[int, np.ndarray]] = [{HOST: uv} for uv in pixels[HOST]]
    for j in range(NUM_CAMERAS):
        if j == HOST:
            continue
        pairs = cv2.BFMatcher(crossCheck=False).knnMatch(found[HOST][1], found[j][1], k=2)
        for best, second in pairs:
            if best.distance < 0.75 * second.distance:
                tracks[best.queryIdx][j] = pixels[j][best.trainIdx]
    return [track for track in tracks if len(track) >= 3]


def refine_features(
    view: View, T_cw: np.ndarray, depth: np.ndarray, tracks: list[dict[int, np.ndarray]]
) -> np.ndarray:
    """T_cw after bundle adjustment of matched SIFT keypoints from the same start."""
    uv = np.array([track[HOST] for track in tracks])
    nearest = np.argmin(np.linalg.norm(uv[:, None] - view.host_uv, axis=-1), axis=1)
    seen = [(j, p, pixel) for p, track in enumerate(tracks) for j, pixel in track.items()]
    problem = BundleProblem(
        CameraModel.PINHOLE,
        T_cw,
        np.tile(CAMERA.params, (NUM_CAMERAS, 1)),
        scenes.back_project(T_cw, uv, depth[nearest]),
        np.array([j for j, _, _ in seen], np.int32),
        np.array([p for _, p, _ in seen], np.int32),
        np.array([pixel for _, _, pixel in seen], np.float64),
    )
    config = BundleConfig(
        gauge="free", constant_cameras=list(HELD), constant_intrinsics=range(NUM_CAMERAS)
    )
    options = BundleOptions(loss=Loss.parse("cauchy:0.7"), lm=LmOptions(max_num_iterations=100))
    return bundle.adjust(problem, config=config, options=options).problem.T_cw


# --- 4. the threshold ---


def measure_threshold(quick: bool) -> list[Result]:
    """Errors against Huber's threshold, and what the fitted laws reach."""
    view = scenes.room()
    rows = []
    for share in (0.0, OUTLIERS):
        for seed in range(1 if quick else 12):
            images = scenes.expose(view, seed)
            begin = scenes.start(view, START_PX, seed, outliers=share)
            fitted = refine_all(view, images, begin, NoiseOptions())
            huber = refine_all(view, images, begin, NoiseOptions(loss="huber"))
            row = {"outliers": share, "sigma": fitted.sigma, "nu": fitted.nu}
            row["student_t"] = scenes.center_rms(view, fitted.T_cw)
            row["huber"] = scenes.center_rms(view, huber.T_cw)
            for factor in THRESHOLDS[::3] if quick else THRESHOLDS:
                noise = NoiseOptions(loss="huber", scale=factor * fitted.sigma)
                found = refine_all(view, images, begin, noise)
                row[f"{factor:g}"] = scenes.center_rms(view, found.T_cw)
            rows.append(row)
    print_table(rows[0], (r.values() for r in rows))
    return rows


def refine_all(
    view: View,
    images: Sequence[np.ndarray],
    begin: tuple[np.ndarray, np.ndarray],
    noise: NoiseOptions,
) -> PhotometricResult:
    """Every point takes part to the end: the law alone has to deal with the wrong ones."""
    return scenes.refine(
        view, images, *begin, noise=noise, visibility=VisibilityOptions(rule="all"), num_levels=1
    )


def measure(quick: bool) -> Result:
    return {
        "depths": measure_depths(quick),
        "patterns": measure_patterns(quick),
        "basin": measure_basin(quick),
        "threshold": measure_threshold(quick),
    }


# --- figures ---


def draw(result: Result) -> dict[str, Figure]:
    return {
        "photometric-inverse-depth": draw_depths(result["depths"]),
        "photometric-patch-size": draw_patterns(result["patterns"]),
        "photometric-features": draw_basin(result["basin"]),
        "photometric-threshold": draw_threshold(result["threshold"]),
    }


def draw_depths(rows: list[Result]) -> Figure:
    figure = style.new_figure(
        11.5, 3.6, "Depth and inverse depth", "points of a wall, known cameras, baseline 1"
    )
    near, far, way = figure.subplots(1, 3)
    for axes, row in zip((near, far), rows, strict=True):
        width = 4.0 * row["sigma_rho"]
        bins = np.linspace(1.0 - width, 1.0 + 1.6 * width, 60)
        for line, key, name in ((LINES[0], "z", "depth"), (LINES[1], "rho", "inverse depth")):
            label = f"{name}, asymmetry {row[f'asymmetry_{key}']:.2f}"
            axes.hist(row[key], bins, histtype="step", color=line["color"], lw=1.6, label=label)
        axes.axvline(1.0, color=style.MUTED, lw=0.8)
        axes.set_title(f"{row['baselines']:g} baselines away")
        axes.set_xlabel("estimate / truth")
        axes.set_ylim(top=1.35 * axes.get_ylim()[1])  # room for the legend
        axes.legend(loc="upper right")
    for line, (kind, costs) in zip(LINES, rows[1]["costs"].items(), strict=False):
        excess = np.minimum.accumulate(costs) / min(costs) - 1.0
        way.semilogy(np.maximum(excess, 1e-9), **line, ms=3.5, label=kind.lower().replace("_", " "))
    way.set_title("from twice the depth, 500 baselines")
    way.set_xlabel("LM iteration")
    way.set_ylabel("cost / best cost − 1")
    way.legend()
    return figure


def draw_patterns(rows: list[Result]) -> Figure:
    figure = style.new_figure(9.0, 3.6, "Patch size", "noise 2 grey levels, start 1.5 px off")
    panels: Sequence[Axes] = figure.subplots(1, 3)
    keys = (
        ("error_mm", 1.0, "camera centres, mm"),
        ("error_px", 1.0, "points in the images, px"),
        ("iteration_s", 1e3, "ms per iteration"),
    )
    for axes, (key, factor, title) in zip(panels, keys, strict=True):
        square = [r for r in rows if r["pattern"] != "spread8"]
        other = [r for r in rows if r["pattern"] == "spread8"]
        for line, group, name in ((LINES[1], square, "squares"), (LINES[0], other, "spread 8")):
            pixels, values = [r["pixels"] for r in group], [factor * r[key] for r in group]
            axes.plot(pixels, values, **line, ms=4.5, label=name)
        axes.set_title(title)
        axes.set_xlabel("pixels of a patch")
        axes.set_ylim(bottom=0.0)
    style.legend_below(figure, panels[0])
    return figure


def draw_basin(rows: list[Result]) -> Figure:
    figure = style.new_figure(6.4, 4.0, "Features or grey values", "error of the camera centres")
    axes = figure.subplots()
    starts = sorted({r["start_px"] for r in rows})
    names = {
        "features": "SIFT, matched once",
        "one_level": "direct, one level",
        "four_levels": "direct, four levels",
        "start_mm": "start",
    }
    for line, (key, name) in zip(LINES, names.items(), strict=True):
        middle = [np.median([r[key] for r in rows if r["start_px"] == px]) for px in starts]
        axes.loglog(starts, middle, **line, ms=4.5, label=name)
    axes.set_xlabel("start: median shift of the projections, px")
    axes.set_ylabel("mm")
    style.legend_below(figure, axes)
    return figure


def draw_threshold(rows: list[Result]) -> Figure:
    figure = style.new_figure(9.0, 3.8, "Huber's threshold", "error of the camera centres, mm")
    panels = figure.subplots(1, 2, sharey=True)
    factors = [key for key in rows[0] if key.replace(".", "").isdigit()]
    for axes, share in zip(panels, (0.0, OUTLIERS), strict=True):
        group = [r for r in rows if r["outliers"] == share]
        values = [rms([r[key] for r in group]) for key in factors]
        axes.loglog([float(key) for key in factors], values, **LINES[1], ms=4.5, label="Huber")
        axes.axvline(1.345, color=style.MUTED, lw=0.8)
        t = rms([r["student_t"] for r in group])
        axes.axhline(t, color=style.ACCENT, linestyle="--", label="Student's t, fitted")
        axes.set_title("no outliers" if share == 0.0 else f"{100 * share:.0f} % wrong depths")
        axes.set_xlabel("threshold / σ")
    style.legend_below(figure, panels[0])
    return figure


if __name__ == "__main__":
    run(__doc__, measure, draw)
