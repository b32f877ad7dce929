"""The problems: real ones where they are at hand, synthetic ones made once and kept in a cache."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import raylign
from harness import judge

ROOT = Path(__file__).resolve().parents[2]
SHARED = Path(os.environ.get("RAYLIGN_DATA", ROOT.parent / "shared" / "data"))
CACHE = Path(os.environ.get("RAYLIGN_BENCH_CACHE", ROOT / "benchmarks" / ".cache"))
SEED = 5
# From the default 0.5 degrees some paths through the 250-camera street leave a point behind a
# camera: another local minimum, and no common final cost to compare times to.
ROTATION_NOISE_DEG = 0.1

# cameras, points, observations of a street and of an orbit: three decades of observations. A short
# street does not see its points more often.
SIZES = (
    (50, 1_000, 3_300, 5_000),
    (50, 10_000, 33_000, 50_000),
    (100, 26_000, 110_000, 130_000),
    (250, 65_000, 325_000, 325_000),
    (500, 150_000, 750_000, 750_000),
    (1000, 300_000, 1_500_000, 1_500_000),
    (1778, 1_000_000, 5_000_000, 5_000_000),
)
SMALL = 130_000  # observations: below, a run takes seconds with every system


@dataclass(frozen=True)
class Spec:
    """A problem by name, and how long a solve of it may go on."""

    name: str
    num_cameras: int
    num_observations: int
    max_iterations: int
    function_tolerance: float
    time_limit_s: float


def synthetic_spec(kind: str, cameras: int, points: int, observations: int) -> Spec:
    """Named as BAL names its files: street-250-65000."""
    name = f"{kind}-{cameras}-{points}"
    if observations <= SMALL:
        return Spec(name, cameras, observations, 100, 1e-8, 60.0)
    large = observations > 1_000_000
    limits = (25, 1e-8, 240.0) if large else (50, 1e-8, 60.0)
    return Spec(name, cameras, observations, *limits)


SYNTHETIC = {
    spec.name: (kind, (cameras, points, observations), spec)
    for which, kind in enumerate(("street", "orbit"))
    for cameras, points, *counts in SIZES
    for observations in [counts[which]]
    for spec in [synthetic_spec(kind, cameras, points, observations)]
}
REAL = {
    "ladybug-49": ("49-7776", Spec("ladybug-49", 49, 31843, 100, 1e-8, 60.0)),
    "ladybug-49-front": ("49-7776", Spec("ladybug-49-front", 49, 31812, 100, 1e-8, 60.0)),
    "trafalgar-21": ("21-11315", Spec("trafalgar-21", 21, 36455, 100, 1e-8, 60.0)),
}
DEFAULT = (
    "ladybug-49-front",
    "trafalgar-21",
    "street-50-10000",
    "orbit-50-10000",
    "street-250-65000",
    "orbit-250-65000",
)


def names() -> list[str]:
    return [*REAL, *SYNTHETIC]


def find_spec(name: str) -> Spec:
    return REAL[name][1] if name in REAL else SYNTHETIC[name][2]


def find_file(name: str) -> Path | None:
    """The text file of a problem, made when it is missing; None: third-party data not at hand."""
    if name in SYNTHETIC:
        kind, size, _ = SYNTHETIC[name]
        return cached(f"{name}.txt", lambda path: write_synthetic(path, kind, size))
    source = SHARED / "bal" / f"problem-{REAL[name][0]}-pre.txt"
    if not source.is_file():
        return None
    if name.endswith("-front"):
        return cached(f"{name}.txt", lambda path: write_front(source, path))
    return source


def cached(name: str, make: Callable[[Path], object]) -> Path:
    """A file or folder of the cache; whole or not there, whatever interrupts its making."""
    path = CACHE / name
    if not path.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        unfinished = CACHE / f"unfinished-{name}"
        make(unfinished)
        unfinished.rename(path)
    return path


def write_synthetic(path: Path, kind: str, size: tuple[int, int, int]) -> None:
    cameras, points, observations = size
    options = raylign.synthetic.BalOptions(
        kind=raylign.synthetic.BalKind[kind.upper()],
        num_cameras=cameras,
        num_points=points,
        num_observations=observations,
        seed=SEED,
        rotation_noise_deg=ROTATION_NOISE_DEG,
    )
    raylign.synthetic.write_bal(path, options=options)


def write_front(source: Path, path: Path) -> None:
    """Leave out what starts behind its camera: COLMAP and GTSAM drop it, the others do not."""
    problem = judge.read_problem(source)
    keep = judge.depths(problem) > 0.0
    raylign.io.write_bal(
        raylign.scene.BalProblem(
            problem.cameras,
            problem.points,
            problem.camera_index[keep].astype("int32"),
            problem.point_index[keep].astype("int32"),
            problem.pixels[keep],
        ),
        path,
    )
