"""raylign: direct and indirect bundle adjustment and direct camera tracking.

>>> import raylign
>>> problem = raylign.synthetic.bal(num_cameras=10, num_points=200, seed=1).problem
>>> result = raylign.bundle.adjust(problem)
>>> result.summary.is_usable()
True
"""

from importlib import import_module
from types import ModuleType

from raylign import (
    bundle,
    camera,
    depth,
    errors,
    geometry,
    image,
    io,
    odometry,
    photometric,
    robust,
    scene,
    synthetic,
    tracking,
    trajectory,
)
from raylign._core import __version__
from raylign.bundle import BundleConfig, BundleOptions, LinearSolverOptions, LmOptions, Termination
from raylign.errors import Error, FormatError, OptionsError, ShapeError
from raylign.robust import Loss, LossType
from raylign.scene import BalProblem

__all__ = [
    "BalProblem",
    "BundleConfig",
    "BundleOptions",
    "Error",
    "FormatError",
    "LinearSolverOptions",
    "LmOptions",
    "Loss",
    "LossType",
    "OptionsError",
    "ShapeError",
    "Termination",
    "__version__",
    "bundle",
    "camera",
    "depth",
    "errors",
    "geometry",
    "image",
    "io",
    "odometry",
    "photometric",
    "robust",
    "scene",
    "synthetic",
    "tracking",
    "trajectory",
]

_ON_DEMAND = ("datasets", "evaluate", "viz")  # matplotlib, pooch: not at `import raylign`


def __getattr__(name: str) -> ModuleType:
    """Import the submodules that need more than NumPy when they are first asked for."""
    if name in _ON_DEMAND:
        return import_module(f"raylign.{name}")
    raise AttributeError(f"module 'raylign' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_ON_DEMAND])
