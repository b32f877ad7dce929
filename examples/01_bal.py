"""Read a BAL problem, adjust it, write it back and report: the whole round in one page.

    python examples/01_bal.py [PROBLEM] [--out FOLDER]

Without PROBLEM a synthetic street is made, whose truth is known.
"""

import argparse
from pathlib import Path

import numpy as np

import raylign.bundle
import raylign.io
import raylign.synthetic
from raylign.bundle import BundleConfig, BundleOptions, Gauge, IterationSummary
from raylign.robust import Loss
from raylign.scene import BalProblem


def load(path: Path | None) -> BalProblem:
    """The problem of the file, or a synthetic one of 16 cameras."""
    if path is not None:
        return raylign.io.read_bal(path)
    return raylign.synthetic.bal(num_cameras=16, num_points=500, seed=1).problem


def print_iteration(row: IterationSummary) -> None:
    """One line per iteration; returning None (not False) lets the solve go on."""
    print(f"{row.iteration:3d}  cost {row.cost:.6e}  lambda {row.lambda_:.1e}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("problem", type=Path, nargs="?", help="BAL file: .txt, .txt.gz, .txt.bz2")
    parser.add_argument("--out", type=Path, default=Path("raylign-demo"))
    arguments = parser.parse_args()

    problem = load(arguments.problem)
    result = raylign.bundle.adjust(
        problem,
        config=BundleConfig(gauge=Gauge.TWO_CAMERAS),
        options=BundleOptions(loss=Loss.parse("huber:1.0")),
        callback=print_iteration,
    )
    print(result.summary.full_report())
    moved = np.linalg.norm(result.problem.points - problem.points, axis=1)
    print(f"points moved by {np.median(moved):.3g} scene units in the median")

    arguments.out.mkdir(parents=True, exist_ok=True)
    raylign.io.write_bal(result.problem, arguments.out / "adjusted.txt")
    raylign.io.write_ply(result.problem, arguments.out / "adjusted.ply")
    print(f"wrote adjusted.txt and adjusted.ply to {arguments.out}")


if __name__ == "__main__":
    main()
