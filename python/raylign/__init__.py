"""raylign: direct and indirect bundle adjustment and direct camera tracking.

>>> import raylign
>>> problem = raylign.synthetic.bal(num_cameras=10, num_points=200, seed=1).problem
>>> result = raylign.bundle.adjust(problem)
>>> result.summary.is_usable()
True
"""

from raylign import bundle, camera, errors, geometry, image, io, robust, scene, synthetic
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
    "errors",
    "geometry",
    "image",
    "io",
    "robust",
    "scene",
    "synthetic",
]
