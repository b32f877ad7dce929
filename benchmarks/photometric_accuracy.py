"""Photometric bundle adjustment on rendered rooms and on the exercise: accuracy. Tables and JSON.

    .venv/bin/python benchmarks/photometric_accuracy.py
    .venv/bin/python benchmarks/photometric_accuracy.py --only noise basin --seeds 6
    .venv/bin/python benchmarks/photometric_accuracy.py --json benchmarks/results/FILE.json

The scenes are those of tests/python/photometric_scenes.py, the bound that of photometric_bound.py
there, which shares no code with raylign. --json FILE keeps the results of the parts measured now
and, of an earlier file, those of the others.
"""

import argparse
import json
import os
import sys
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from harness import machine
from harness.problems import ROOT

sys.path.insert(0, str(ROOT / "tests" / "python"))

import photometric_bound
import photometric_scenes as scenes
from photometric_scenes import Path as Motion
from raylign import photometric
from raylign.geometry import se3_inverse, se3_log
from raylign.photometric import EdgeStatus, PhotometricOptions, PointStatus

SEEDS = {
    "noise": 20,
    "variants": 6,
    "covariance": 50,
    "brightness": 6,
    "disturbed": 6,
    "basin": 3,
    "starts": 50,
    "exercise": 1,
}
GAINS = 0.3 * np.array([0.0, 0.9, -0.8, 0.5, -1.0, 0.7, -0.4])
BIASES = 20.0 * np.array([0.0, -0.6, 0.9, -1.0, 0.4, 0.8, -0.3])
VARIANTS: dict[str, dict] = {
    "defaults": {},
    "inverse depth": {"point_parametrization": "inverse_depth"},
    "presmooth by noise": {"presmooth": -1.0},
    "presmooth 0.7 px": {"presmooth": 0.7},
    "least squares": {"noise": photometric.NoiseOptions(loss="trivial")},
    "Huber": {"noise": photometric.NoiseOptions(loss="huber")},
    "bilinear": {"interpolation": "bilinear"},
    "constant host depth": {"warp": "depth"},
    "no warp": {"warp": "none"},
}
START_PX = 1.7


def rounded(sigma: float) -> float:
    """Noise of a pixel after rounding to 8 bits."""
    return float(np.sqrt(sigma**2 + 1.0 / 12.0))


@lru_cache
def unit_bound(path: Motion) -> photometric_bound.Bound:
    return photometric_bound.bound(scenes.make(path), 1.0, brightness=True)


def bound_mm(path: Motion, sigma: float) -> float:
    return 1e3 * rounded(sigma) * unit_bound(path).centre_rms


def error_mm(truth: scenes.Truth, result) -> float:
    return 1e3 * scenes.centre_rms(truth, result.T_cw)


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def one(path: Motion, sigma: float, seed: int, px: float = START_PX, **options):
    truth = scenes.make(path)
    images = scenes.expose(truth, sigma=sigma, seed=seed)
    return truth, scenes.refine(truth, images, scenes.shifted(truth, px, seed=seed), **options)


def noise(seeds: int) -> list[dict]:
    """RMSE of the camera centres beside the bound, sharp and smoothed by the noise."""
    rows = []
    for presmooth in (0.0, -1.0):
        for path in (Motion.SMALL, Motion.LARGE):
            for sigma in (1.0, 2.0, 4.0, 8.0):
                errors, accepted = [], 0
                for seed in range(seeds):
                    truth, result = one(path, sigma, seed, presmooth=presmooth)
                    errors.append(error_mm(truth, result))
                    accepted += result.accepted
                bound = bound_mm(path, sigma)
                rows.append({"motion": path.name.lower(), "sigma": sigma, "seeds": seeds,
                             "presmooth": float(result.presmooth),
                             "rmse_mm": rms(errors), "worst_mm": max(errors), "bound_mm": bound,
                             "ratio": rms(errors) / bound, "accepted": accepted})  # fmt: skip
    return rows


def variants(seeds: int) -> list[dict]:
    """The same at sigma 2 with other options."""
    rows = []
    for name, options in VARIANTS.items():
        row: dict = {"variant": name, "seeds": seeds}
        for path in (Motion.SMALL, Motion.LARGE):
            errors = []
            for seed in range(seeds):
                truth, result = one(path, 2.0, seed, force=True, **options)
                errors.append(error_mm(truth, result))
            key = path.name.lower()
            row[key] = {"rmse_mm": rms(errors), "ratio": rms(errors) / bound_mm(path, 2.0)}
        rows.append(row)
    return rows


def nees(truth: scenes.Truth, result) -> float:
    """Squared error of the free poses in their own covariance, per degree of freedom."""
    free = range(1, scenes.NUM_CAMERAS - 1)
    xi = [se3_log(truth.T_cw[j] @ se3_inverse(result.T_cw[j])) for j in free]
    index = np.concatenate([np.arange(6 * j, 6 * j + 6) for j in free])
    e = np.concatenate(xi)
    return float(e @ np.linalg.solve(result.pose_covariance[np.ix_(index, index)], e)) / len(e)


def point_nees(truth: scenes.Truth, result) -> float:
    """Median over the points of the squared error in their covariance, per degree of freedom.

    Of the depth alone, along the host's ray: across it the host's own pixel defines the point.
    """
    rays = truth.points - truth.centres[truth.hosts]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    e = np.einsum("ni,ni->n", result.points - truth.points, rays)
    variance = np.einsum("ni,nij,nj->n", rays, result.point_covariances, rays)
    ok = (result.point_status == PointStatus.OK.value) & np.isfinite(variance)
    return float(np.median(e[ok] ** 2 / variance[ok]) / 0.4549)  # median of chi2 with 1 dof


def covariance(seeds: int) -> list[dict]:
    """NEES: 1 where the covariance says what the error is."""
    rows = []
    for path in (Motion.SMALL, Motion.LARGE):
        poses, points = [], []
        for seed in range(seeds):
            truth, result = one(path, 2.0, seed, covariance="all")
            if result.accepted:
                poses.append(nees(truth, result))
                points.append(point_nees(truth, result))
        rows.append({"motion": path.name.lower(), "seeds": len(poses),
                     "pose_nees": float(np.mean(poses)),
                     "depth_nees": float(np.mean(points))})  # fmt: skip
    return rows


def relative_brightness(brightness: np.ndarray) -> np.ndarray:
    a, b = (brightness - brightness[0]).T
    return np.stack([a, b * np.exp(-brightness[0, 0])], axis=1)


def brightness(seeds: int) -> dict:
    """Images of other gain and bias: error beside that of equal images, and a, b."""
    truth = scenes.make(Motion.SMALL)
    a = GAINS[0] - GAINS
    expected = np.stack([a, BIASES[0] - np.exp(a) * BIASES], axis=1)
    errors: dict[str, list[float]] = {"equal": [], "changed": [], "ignored": []}
    a_errors, b_errors = [], []
    for seed in range(seeds):
        start = scenes.shifted(truth, START_PX, seed=seed)
        equal = scenes.expose(truth, sigma=2.0, seed=seed)
        changed = scenes.expose(truth, sigma=2.0, seed=seed, gain=GAINS, bias=BIASES)
        none = {"brightness": photometric.BrightnessOptions(model="none"), "force": True}
        for name, images, options in (
            ("equal", equal, {}),
            ("changed", changed, {}),
            ("ignored", changed, none),
        ):
            result = scenes.refine(truth, images, start, **options)
            errors[name].append(error_mm(truth, result))
            if name == "changed":
                off = np.abs(relative_brightness(result.brightness) - expected).max(axis=0)
                a_errors.append(float(off[0]))
                b_errors.append(float(off[1]))
    means = {name: rms(values) for name, values in errors.items()}
    return {"seeds": seeds, "rmse_mm": means, "ratio": means["changed"] / means["equal"],
            "worst_a": max(a_errors), "worst_b": max(b_errors)}  # fmt: skip


def disturbed(seeds: int) -> dict:
    """20 % of the depths wrong by 30 %, a tenth of the views hidden, a twentieth white."""
    truth = scenes.make(Motion.MEDIUM, board=True)
    open_view = replace(truth, irradiance=scenes.make(Motion.MEDIUM).irradiance)
    errors: dict[str, list[float]] = {"clean": [], "disturbed": []}
    caught, false, righted = [], [], []
    white = scenes.white_patches(truth, exposure=scenes.SATURATING)
    for seed in range(seeds):
        start = scenes.shifted(truth, START_PX, seed=seed)
        bad, wrong = scenes.with_wrong_depths(truth, start, share=0.2, error=0.3, seed=seed)
        clean = scenes.refine(truth, scenes.expose(open_view, sigma=2.0, seed=seed), start)
        images = scenes.expose(truth, sigma=2.0, seed=seed, exposure=scenes.SATURATING)
        result = scenes.refine(truth, images, bad)
        errors["clean"].append(error_mm(truth, clean))
        errors["disturbed"].append(error_mm(truth, result))
        off = scenes.point_errors_px(truth, result) > 1.0
        flagged = result.point_status != PointStatus.OK.value
        caught.append(float(flagged[wrong & off].mean()))
        righted.append(float((~off)[wrong].mean()))
        false.append(float(flagged[~wrong & ~white].mean()))
    means = {name: rms(values) for name, values in errors.items()}
    return {"seeds": seeds, "rmse_mm": means, "ratio": means["disturbed"] / means["clean"],
            "wrong_put_right": float(np.mean(righted)), "wrong_flagged": float(np.mean(caught)),
            "white": float(white.mean()), "good_flagged": float(np.mean(false))}  # fmt: skip


def basin(seeds: int) -> list[dict]:
    """How far off a start may be, by the number of levels; 0: chosen by raylign, more seeds."""
    rows = [
        basin_row(px, levels, seeds) for px in (1.7, 5.8, 11.6, 23.0) for levels in (1, 2, 3, 4)
    ]
    rows += [basin_row(px, 0, 3 * seeds) for px in (1.7, 5.8, 11.6, 13.8, 17.0, 23.0, 30.0)]
    return rows


def basin_row(px: float, levels: int, seeds: int) -> dict:
    truth = scenes.make(Motion.MEDIUM)
    errors, times, accepted, wrong = [], [], 0, 0
    for seed in range(seeds):
        images = scenes.expose(truth, sigma=2.0, seed=seed)
        start = scenes.shifted(truth, px, seed=seed)
        result = scenes.refine(truth, images, start, num_levels=levels)
        errors.append(error_mm(truth, result))
        times.append(result.summary.total_time_s)
        accepted += result.accepted
        before = 1e3 * scenes.centre_rms(truth, start.T_cw)
        wrong += bool(result.accepted and errors[-1] > before)
    recovered = np.array(errors) < 3.0 * bound_mm(Motion.MEDIUM, 2.0)
    return {"px": px, "levels": levels, "seeds": seeds, "recovered": int(np.sum(recovered)),
            "within_1_mm": int(np.sum(np.array(errors) < 1.0)), "accepted": accepted,
            "accepted_but_worse": wrong,
            "median_mm": float(np.median(errors)), "median_s": float(np.median(times))}  # fmt: skip


def starts(count: int) -> dict:
    """Bad starts, 10 to 40 px off: better, or not accepted."""
    truth = scenes.make(Motion.MEDIUM)
    rows = []
    for index in range(count):
        px = float(np.random.default_rng([index, 11]).uniform(10.0, 40.0))
        start = scenes.shifted(truth, px, seed=100 + index)
        result = scenes.refine(truth, scenes.expose(truth, sigma=2.0, seed=index), start)
        rows.append({"px": px, "accepted": result.accepted, "error_mm": error_mm(truth, result),
                     "start_mm": 1e3 * scenes.centre_rms(truth, start.T_cw)})  # fmt: skip
    accepted = [row for row in rows if row["accepted"]]
    return {"starts": count, "accepted": len(accepted),
            "accepted_but_worse": sum(r["error_mm"] >= r["start_mm"] for r in accepted),
            "recovered": sum(r["error_mm"] < 3.0 * bound_mm(Motion.MEDIUM, 2.0) for r in rows),
            "within_1_mm": sum(r["error_mm"] < 1.0 for r in rows),
            "rows": rows}  # fmt: skip


def exercise(_: int) -> dict:
    """The data of the exercise: its own way, and the default options on the real image 0."""
    folder = Path(os.environ.get("RAYLIGN_DATA", ROOT.parent / "shared" / "data")) / "direct_ba"
    if not folder.is_dir():
        return {"error": f"no data in {folder}"}
    K = [float(np.float32(x)) for x in (277.34, 291.402, 312.234, 239.777)]  # as the exercise
    files = [folder / f"{i}.png" for i in range(7)]
    names = (folder / "points.txt", folder / "poses.txt")
    way = photometric.preset("exercise")
    copied = photometric.Problem.from_text(*names, [files[1], *files[1:]], K)
    own = photometric.adjust(copied, options=way.options, config=way.config)
    real = photometric.Problem.from_text(*names, files, K)
    result = photometric.adjust(real, options=PhotometricOptions())
    before, after = median_pixel(result)
    # chi2 as the exercise prints it, after each step that it took
    steps = [(2.0 * float(row["cost"]), float(row["lambda"]))
             for row in own.summary.iterations
             if row["iteration"] == 0 or row["step_is_accepted"]]  # fmt: skip
    return {"preset_start": steps[0], "preset_first_step": steps[1],
            "preset_step_35": steps[min(35, len(steps) - 1)],
            "default_median_pixel": {"before": before, "after": after},
            "default_accepted": result.accepted, "sigma": result.sigma, "nu": result.nu,
            "views": int((result.edge_status == EdgeStatus.OK.value).sum()),
            "time_s": result.summary.total_time_s}  # fmt: skip


def median_pixel(result) -> tuple[float, float]:
    """Median over the views that are used of the RMS residual of a pixel, before and after."""
    ok = result.edge_status == EdgeStatus.OK.value
    return (float(np.nanmedian(result.edge_rms_before[ok])),
            float(np.nanmedian(result.edge_rms_after[ok])))  # fmt: skip


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=tuple(SEEDS), default=tuple(SEEDS))
    parser.add_argument("--seeds", type=int, help="default: by part")
    parser.add_argument("--json", type=Path, help="default: no file")
    return parser.parse_args(arguments)


def main() -> int:
    arguments = parse_arguments()
    facts = machine.facts()
    for part in arguments.only:
        result = globals()[part](arguments.seeds or SEEDS[part])
        print(f"\n## {part}\n\n{json.dumps(result, indent=1)}", flush=True)
        if arguments.json is not None:
            path = arguments.json
            earlier = json.loads(path.read_text()) if path.exists() else {}
            merged = earlier | {part: {"machine": facts, "result": result}}
            path.write_text(json.dumps(merged, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
