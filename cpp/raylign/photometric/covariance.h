// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"

namespace raylign {

struct CovarianceOptions {
  bool points = false;  ///< also those of the points
  /// Share of a residual's variance that is noise of the patch, the same in every image, in [0, 1];
  /// negative: estimated from how the residuals of a pixel agree between images.
  double shared_noise = -1.0;
  double presmooth = 0.0;  ///< σ of the Gaussian that the images were smoothed with, px; >= 0
  /// What the information of a prior was multiplied with to become one of the cost, grey²; 0: the
  /// residuals' own variance.
  double prior_unit = 0.0;
};

/// How well a minimum of a PatchScene is known.
struct PhotometricCovariance {
  /// (6M, 6M) of ξ = [υ; ω] of each image, T_cw = exp(ξ) T_estimate, relative to what is held; rows
  /// and columns of held coordinates are zero.
  Eigen::MatrixXd poses;
  Rows<double, 9> points;  ///< (N, 9) of world points, row-major 3x3; NaN: not determined
  double variance = 0.0;   ///< grey²: H⁻¹ of the weighted normal matrix is multiplied by it
  double shared_noise = 0.0;
  /// Mean number of patches that a patch's pixel belongs to, itself included: where it is far above
  /// 1, residuals repeat each other and the covariance is too small by up to this factor.
  double overlap = 1.0;
  /// Directions that nothing determines: 7 of a free gauge. The covariance is then that of smallest
  /// trace, of scaled coordinates.
  int free_directions = 0;
};

/// Covariance of the estimate that `options` found, at the scene's state. H is the normal matrix
/// with the law's weights w = ρ′ and all free coordinates, brightness and intrinsics too. Noise of
/// a patch is in all its residuals at once:
///
///   C = v H⁻¹ B H⁻¹,   B = Σ √w √w′ j j′ᵀ ((1 − s) δ_vv′ + s)   over images v, v′ of each pixel,
///
/// s = shared_noise; the image that a patch was read from has none of either. What noise of the
/// images adds to the squares of their gradients is taken out of H. The scale v comes
/// from how the gradients g = Σ w j r of the points scatter once the point itself is eliminated: it
/// is tr(S⁻¹ Σ g gᵀ) over what B makes of it, times (E[w] / E[ψ′])², ψ = w r (Huber, Robust
/// Statistics, 1981, §7.6). Unlike the variance of single residuals that counts what they have in
/// common inside a patch, as interpolated noise has. Without free cameras v = n/(n − p) E[ψ²] E[w]
/// / E[ψ′]². For inverse depth, the points' covariances contain that of the host. Throws
/// OptionsError for a share above 1.
PhotometricCovariance photometric_covariance(const PatchScene& scene,
                                             const PatchConstraints& constraints,
                                             const PatchSolveOptions& options,
                                             const CovarianceOptions& covariance = {});

}  // namespace raylign
