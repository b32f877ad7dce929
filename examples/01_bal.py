"""Read a BAL problem, adjust it, write it back and report: the whole round in one page.

    python examples/01_bal.py [PROBLEM] [--out FOLDER]

Without PROBLEM a synthetic street with 2 % outliers is made; its truth is known, and the distance
of the camera centres from it is printed before and after.
"""

import argparse
from pathlib import Path

import numpy as np

import raylign.bundle
import raylign.evaluate
import raylign.io
import raylign.synthetic
from raylign.bundle import BundleConfig, BundleOptions, Gauge, IterationSummary
from raylign.robust import Loss
from raylign.scene import BalProblem


def load(path: Path | None) -> tuple[BalProblem, BalProblem | None]:
    """The problem of the file, or a synthetic one with its truth."""
    if path is not None:
        return raylign.io.read_bal(path), None
    scene = raylign.synthetic.bal(
        num_cameras=16,
        num_points=1500,
        views_per_stop=2,
        mean_track_length=8.0,
        focal=380.0,
        outlier_fraction=0.02,
        translation_noise=0.04,
        point_noise=0.04,
        seed=1,
    )
    return scene.problem, scene.truth


def center_rms(problem: BalProblem, truth: BalProblem) -> float:
    """RMS distance of the camera centres from the truth after the best similarity, m."""
    return float(np.sqrt(np.mean(raylign.evaluate.camera_center_errors(problem, truth) ** 2)))


def print_iteration(row: IterationSummary) -> None:
    """One line per iteration; returning None (not False) lets the solve go on."""
    print(f"{row.iteration:3d}  cost {row.cost:.6e}  lambda {row.lambda_:.1e}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("problem", type=Path, nargs="?", help="BAL file: .txt, .txt.gz, .txt.bz2")
    parser.add_argument("--out", type=Path, default=Path("raylign-demo"))
    arguments = parser.parse_args()

    problem, truth = load(arguments.problem)
    result = raylign.bundle.adjust(
        problem,
        config=BundleConfig(gauge=Gauge.TWO_CAMERAS),
        options=BundleOptions(loss=Loss.parse("cauchy:1.0")),
        callback=print_iteration,
    )
    print(result.summary.full_report())
    moved = np.linalg.norm(result.problem.points - problem.points, axis=1)
    print(f"points moved by {np.median(moved):.3g} scene units in the median")
    if truth is not None:
        before, after = center_rms(problem, truth), center_rms(result.problem, truth)
        print(f"camera centres off by {before:.3f} m before, {after:.3f} m after")

    arguments.out.mkdir(parents=True, exist_ok=True)
    raylign.io.write_bal(result.problem, arguments.out / "adjusted.txt")
    raylign.io.write_ply(result.problem, arguments.out / "adjusted.ply")
    print(f"wrote adjusted.txt and adjusted.ply to {arguments.out}")


if __name__ == "__main__":
    main()
