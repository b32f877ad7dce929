"""Synthetic problems of Bundle Adjustment in the Large."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from raylign import _core
from raylign._core import BalOptions
from raylign._typing import Bool, PathLike
from raylign.errors import OptionsError
from raylign.scene import BalProblem


@dataclass(frozen=True)
class SyntheticBal:
    """What `bal` returns.

    Attributes:
        problem: perturbed start; observations with noise and outliers, ordered by point, then
            camera. `points` (P, 3) float64, world frame, m; `colors` (P, 3) uint8.
        truth: the same observations with the true cameras and points.
        inlier_mask: (N,) bool; False where the observation is a uniform random pixel.
        options: what made it.
    """

    problem: BalProblem
    truth: BalProblem
    inlier_mask: Bool
    options: BalOptions


def bal(options: BalOptions | None = None, **changes: Any) -> SyntheticBal:
    """Generate a bundle adjustment problem in the convention of Bundle Adjustment in the Large.

    Points are drawn in the picture of one camera each and matched in others that see them: inside
    the image, near enough, facing the surface, nothing in between. Every point has at least two
    observations, the camera graph is connected, and all points are in front of their cameras.
    Track lengths follow a Lomax law: most 2 to 4, a tail up to a thousand.

    Args:
        options: defaults to `BalOptions()`.
        **changes: single options by name, over `options`; `kind` also as "street" or "orbit".

    Returns:
        SyntheticBal: perturbed `problem`, `truth`, `inlier_mask`, `options`.

    Raises:
        OptionsError: an option is out of range, or the scene cannot give what is asked (more
            observations than the cameras can see; a camera that shares nothing with the others).
        TypeError: there is no option of that name.

    Note: deterministic. Releases the GIL. Takes about a microsecond per observation.

    Example:
        >>> from raylign.synthetic import bal
        >>> scene = bal(kind="orbit", num_cameras=12, num_points=400, seed=7)
        >>> scene.problem.num_cameras, scene.problem.num_points, scene.inlier_mask.all().item()
        (12, 400, True)
    """
    chosen = _merge(options, changes)
    problem, truth, inlier_mask = _core.synthetic_bal(chosen)
    return SyntheticBal(problem, truth, inlier_mask, chosen)


def write_bal(
    path: PathLike,
    *,
    options: BalOptions,
    truth_path: PathLike | None = None,
    progress: Callable[[int, int], bool | None] | None = None,
) -> tuple[int, int, int]:
    """Write the problem of `bal(options)` to a BAL file without holding it in memory.

    Reading the file gives `bal(options).problem` bit for bit (without colours). Besides the
    cameras, four bytes per point are kept; the rest is drawn from the seed again when its turn
    comes.

    Args:
        path: target; compressed when it ends in `.gz` or `.bz2`. Written beside the target and
            renamed at the end: after a failure the old file is as it was.
        options: what to generate.
        truth_path: where to write the same observations with true cameras and points.
        progress: called now and then with (observations written, observations in all); return
            False to stop.

    Returns:
        (cameras, points, observations) in the file.

    Raises:
        OptionsError: see `bal`; or both paths are the same.
        FormatError: a target cannot be written.
        Error: `progress` returned False.

    Note: deterministic, also when compressed. Releases the GIL.

    Example:
        >>> import pathlib, tempfile
        >>> from raylign.synthetic import BalKind, BalOptions, write_bal
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     write_bal(
        ...         pathlib.Path(folder) / "orbit.txt.gz",
        ...         options=BalOptions(kind=BalKind.ORBIT, num_cameras=8, num_points=100),
        ...     )[:2]
        (8, 100)
    """
    if truth_path is not None and os.path.realpath(path) == os.path.realpath(truth_path):
        raise OptionsError(f"path and truth_path are the same file: {os.fspath(path)}")
    truth = None if truth_path is None else os.fspath(truth_path)
    return _core.write_synthetic_bal(options, os.fspath(path), truth_path=truth, progress=progress)


def _merge(options: BalOptions | None, changes: dict[str, Any]) -> BalOptions:
    return (BalOptions() if options is None else options).replace(**changes)
