"""The solve, and sets of options that belong together."""

from collections.abc import Callable
from typing import NamedTuple

from raylign import _core
from raylign._core import (
    BrightnessModel,
    BrightnessOptions,
    BundleConfig,
    CovarianceScope,
    CramerRaoBound,
    Gauge,
    IterationSummary,
    LeavingRule,
    LmOptions,
    LossScope,
    LossType,
    NoiseOptions,
    PatchBorder,
    PatchWarp,
    PhotometricOptions,
    SampleInterpolation,
    VisibilityOptions,
    VisibilityRule,
)
from raylign.errors import OptionsError
from raylign.photometric._problem import Problem
from raylign.photometric._result import PhotometricResult

_ANY_GREY = 1e9  # a limit that no grey value reaches


class Preset(NamedTuple):
    """Options and configuration that go together."""

    options: PhotometricOptions
    config: BundleConfig | None


def preset(name: str) -> Preset:
    """Settings by name.

    Args:
        name: "default"; or "exercise": the course exercise that this problem is known from, with
            its peculiarities: bilinear values with central differences as gradient, Huber's law at
            1 on the norm of a patch, no cost out of view, no brightness, one level, nothing held
            fixed, additive damping, no acceptance test. Its log can be compared line by line; for
            results take the default.

    Raises:
        OptionsError: no preset has that name.

    Example:
        >>> preset("exercise").options.noise.scale
        1.0
    """
    if name == "default":
        return Preset(PhotometricOptions(), None)
    if name != "exercise":
        raise OptionsError(f"preset must be 'default' or 'exercise', got {name!r}")
    options = PhotometricOptions(
        warp=PatchWarp.NONE,
        interpolation=SampleInterpolation.CENTRAL_DIFFERENCE,
        presmooth=0.0,
        num_levels=1,
        brightness=BrightnessOptions(model=BrightnessModel.NONE, balanced=False),
        noise=NoiseOptions(loss=LossType.HUBER, scope=LossScope.PATCH, scale=1.0),
        visibility=VisibilityOptions(
            rule=VisibilityRule.ALL,
            min_grey=-_ANY_GREY,
            max_grey=_ANY_GREY,
            min_texture=0.0,
            min_views=1,
        ),
        max_num_rounds=1,
        hold_out=0,
        force=True,
        covariance=CovarianceScope.NONE,
        leaving=LeavingRule.ZERO,
        max_leaving_share=1.0,
        border=PatchBorder.WRAP,
        min_depth=float("-inf"),
        lm=LmOptions(
            max_num_iterations=200,
            function_tolerance=0.0,
            gradient_tolerance=0.0,
            parameter_tolerance=0.0,
            initial_lambda=1e-5,
            min_relative_decrease=0.0,
        ),
        additive_damping=True,
    )
    return Preset(options, BundleConfig(gauge=Gauge.FREE))


def adjust(
    problem: Problem,
    *,
    config: BundleConfig | None = None,
    options: PhotometricOptions | None = None,
    callback: Callable[[IterationSummary], bool | None] | None = None,
) -> PhotometricResult:
    """Refine poses and points so that the images agree with the points' patches.

    Minimises Σ ρ(r), r_n = c_n − (e^{a_j − a_h} I_j(π(T_j X) + A o_n) + e^{−a_h} (b_j − b_h)), over
    poses T_cw, points X and each image's brightness a, b, from coarse to fine; the law ρ is fitted
    to the residuals. Points that are held out decide whether the result is better than the start;
    if not, the start is returned with `accepted` false and the reason.

    Args:
        problem: images, cameras, points; not modified.
        config: what is held fixed. Default: priors on poses or points anchor the result; with
            depths of known uncertainty the first camera is held; else the first camera and the
            scale (gauge `TWO_CAMERAS`).
        options: how to solve. Default: `PhotometricOptions()`.
        callback: called after each iteration; return False to stop. An exception in it stops the
            solve and is raised again here.

    Returns:
        PhotometricResult: look at `accepted`. Ctrl-C, a stop by the callback and the time limit
        give the best state so far, `summary.termination` saying so; numerical failure is
        `Termination.FAILURE`.

    Raises:
        ShapeError: no point is in view of two images, or the pattern is not that of the stored
            patches.
        OptionsError: an option is out of range, or does not go with the problem.

    Note: the same bits for any number of threads with backend NATIVE. Releases the GIL.

    Source:
        Alismail, Browning & Lucey, Photometric Bundle Adjustment for Vision-Based SLAM, ACCV 2016;
        Engel, Koltun & Cremers, Direct Sparse Odometry, PAMI 2018 (affine brightness, inverse
        depth); docs/theory/photometric.md.
    """
    chosen = PhotometricOptions() if options is None else options
    if problem.is_corrected:  # the masks are of the raw values, the limits would be of corrected
        visibility = chosen.visibility.replace(min_grey=-_ANY_GREY, max_grey=_ANY_GREY)
        chosen = chosen.replace(visibility=visibility)
    held = default_config(problem) if config is None else config
    core = _core.adjust_photometric(problem._core, config=held, options=chosen, callback=callback)
    return PhotometricResult(problem, chosen, held, core)


def cramer_rao(
    truth: Problem,
    *,
    sigma: float,
    config: BundleConfig | None = None,
    options: PhotometricOptions | None = None,
    is_rounded: bool = False,
    has_noisy_patches: bool = False,
) -> CramerRaoBound:
    """How well poses and points can be known at best: the inverse of the Fisher information.

    Args:
        truth: images without noise, with the true poses and points.
        sigma: of the noise of a pixel, grey levels, > 0.
        config: what is held fixed; default: as `adjust`.
        options: pattern, warp, views, what is refined; the law of the residuals is not used.
        is_rounded: grey values are whole numbers, which adds 1/12 to the variance.
        has_noisy_patches: patches are read from images with the same noise.

    Returns:
        CramerRaoBound: covariances in the order of `PhotometricResult`.

    Raises:
        OptionsError: `sigma` is not > 0, or patches without host would be noisy.
        ShapeError: as `adjust`.

    Source:
        Rao 1945; docs/theory/photometric.md.
    """
    return _core.photometric_cramer_rao(
        truth._core,
        config=default_config(truth) if config is None else config,
        options=PhotometricOptions() if options is None else options,
        sigma=sigma,
        is_rounded=is_rounded,
        has_noisy_patches=has_noisy_patches,
    )


def default_config(problem: Problem) -> BundleConfig:
    """What `adjust` holds fixed unless told: as little as it takes to anchor the result."""
    return BundleConfig(gauge=problem._core.default_gauge())
