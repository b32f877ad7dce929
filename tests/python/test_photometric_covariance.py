"""The covariances that photometric adjustment claims are those that its results have.

Short version of T13; the full one, 50 seeds, is in docs/theory/photometric.md.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import photometric_bound
import photometric_scenes as scenes
from photometric_scenes import Path
from raylign import photometric
from raylign.bundle import BundleConfig
from raylign.geometry import se3_exp, se3_inverse, se3_log

SIGMA = 2.0
MIN_DISTANCE = 7.0  # px
SEEDS = range(12)
FREE = list(range(1, scenes.NUM_CAMERAS - 1))
POSES = np.concatenate([np.arange(6 * j, 6 * j + 6) for j in FREE])


@lru_cache
def truth() -> scenes.Truth:
    """Points that share no pixels: noise in common would be in no residual's statistics."""
    room = scenes.make(Path.SMALL, num_points=760)
    uv = scenes.project(room.T_cw, room.points)[0][:, scenes.NUM_CAMERAS // 2]
    kept: list[int] = []
    for p in range(len(uv)):
        if np.abs(uv[kept] - uv[p]).max(axis=1).min(initial=np.inf) > MIN_DISTANCE:
            kept.append(p)
    rows = ("points", "hosts", "host_uv", "normals", "seen")
    return replace(room, **{name: getattr(room, name)[kept] for name in rows})


@lru_cache
def results(presmooth: float = 0.0, seeds: range = SEEDS) -> list[photometric.PhotometricResult]:
    return [
        refine(
            scenes.expose(truth(), sigma=SIGMA, seed=seed),
            scenes.shifted(truth(), 0.5, seed=seed),
            presmooth=presmooth,
        )
        for seed in seeds
    ]


def refine(
    images: list[np.ndarray],
    start: scenes.Start,
    *,
    presmooth: float = 0.0,
    pose_covariance: np.ndarray | None = None,
) -> photometric.PhotometricResult:
    problem = photometric.Problem(
        images,
        scenes.CAMERA,
        start.T_cw,
        start.points,
        host=truth().hosts,
        host_uv=truth().host_uv,
        normals=truth().normals,
        pose_covariance=pose_covariance,
    )
    held = BundleConfig(gauge="free", constant_cameras=[0, scenes.NUM_CAMERAS - 1])
    options = photometric.PhotometricOptions(
        num_levels=1,
        hold_out=0,
        presmooth=presmooth,
        covariance=photometric.CovarianceScope.ALL,
    )
    return photometric.adjust(problem, config=held, options=options)


def pose_nees(result: photometric.PhotometricResult) -> float:
    xi = se3_log(truth().T_cw @ se3_inverse(result.T_cw))[FREE].ravel()
    covariance = result.pose_covariance[np.ix_(POSES, POSES)]
    return float(xi @ np.linalg.solve(covariance, xi) / len(xi))


# With 0.7 px of smoothing and the gradient noise of sharp images: poses 0.35.
SMOOTHED = (0.7, range(6))


@pytest.mark.slow
@pytest.mark.parametrize("images", [(0.0, SEEDS), SMOOTHED], ids=["sharp", "smoothed"])
def test_poses_scatter_as_their_covariance_says(images: tuple[float, range]) -> None:
    assert 0.8 < np.mean([pose_nees(result) for result in results(*images)]) < 1.2


@pytest.mark.slow
def test_priors_count_for_what_they_are() -> None:
    """Poses known beforehand about as well as the images say: both together are as claimed."""
    sigma = np.array([1.5e-4] * 3 + [5e-5] * 3)  # m, rad
    covariance = np.tile(np.diag(sigma**2), (scenes.NUM_CAMERAS, 1, 1))
    nees = []
    for seed in range(6):
        xi = sigma * np.random.default_rng([seed, 3]).normal(size=(scenes.NUM_CAMERAS, 6))
        xi[[0, -1]] = 0.0
        start = replace(scenes.shifted(truth(), 0.5, seed=seed), T_cw=se3_exp(xi) @ truth().T_cw)
        images = scenes.expose(truth(), sigma=SIGMA, seed=seed)
        result = refine(images, start, pose_covariance=covariance)
        nees.append(pose_nees(result))
        alone = results()[seed].pose_covariance
        assert np.trace(result.pose_covariance) < 0.7 * np.trace(alone)
    assert 0.75 < np.mean(nees) < 1.25


@pytest.mark.slow
@pytest.mark.parametrize("images", [(0.0, SEEDS), SMOOTHED], ids=["sharp", "smoothed"])
def test_points_scatter_as_their_covariance_says(images: tuple[float, range]) -> None:
    nees = []
    for result in results(*images):
        error = result.points - truth().points
        kept = np.isfinite(result.point_covariances).all(axis=(1, 2))
        assert kept.mean() > 0.95
        solved = np.linalg.solve(result.point_covariances[kept], error[kept][..., None])[..., 0]
        nees.append(np.median(np.einsum("ni,ni->n", error[kept], solved)))
    # The median of chi-square with three degrees of freedom.
    assert 0.85 < np.mean(nees) / 2.366 < 1.2


@pytest.mark.slow
def test_claims_are_close_to_what_is_possible() -> None:
    """Neither modest nor bold: the covariance is that of an estimate near the bound."""
    sigma = float(np.sqrt(SIGMA**2 + 1.0 / 12.0))
    bound = photometric_bound.bound(truth(), sigma, brightness=True)
    best = np.trace(bound.covariance.reshape(len(POSES), len(POSES)))
    for result in results():
        claimed = np.trace(result.pose_covariance[np.ix_(POSES, POSES)])
        assert 0.85 < claimed / best < 1.3


@pytest.mark.slow
def test_what_residuals_share_is_seen() -> None:
    for result in results():
        assert 0.4 < result.shared_noise < 0.65  # of the patch: 1 of 1 + 0.76
        assert 1.0 <= result.covariance_overlap < 1.1
        assert result.free_directions == 0


@pytest.mark.slow
def test_held_cameras_have_no_covariance() -> None:
    covariance = results()[0].pose_covariance
    assert (covariance[:6] == 0.0).all()
    assert (covariance[:, -6:] == 0.0).all()
