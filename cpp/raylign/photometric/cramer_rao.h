// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"

namespace raylign {

struct CramerRaoOptions {
  double sigma = 1.0;              ///< of the noise of one pixel, grey, > 0
  bool is_rounded = false;         ///< grey values are whole numbers: adds 1/12 to the variance
  bool has_noisy_patches = false;  ///< patches are read from their hosts, with the same noise

  /// Throws OptionsError.
  void validate() const;
};

/// The smallest covariance that an unbiased estimate can have.
struct CramerRaoBound {
  Eigen::MatrixXd poses;    ///< (6M, 6M) of ξ = [υ; ω], T_cw = exp(ξ) T_true; zero where held
  Rows<double, 9> centers;  ///< (M, 9) of the cameras' centres, world frame, row-major 3x3
  Rows<double, 9> points;   ///< (N, 9) of world points; NaN: not determined
  int free_directions = 0;  ///< directions that the images leave free; bounds are of the rest
};

/// Inverse of the Fisher information of the grey values, at a scene that holds the true parameters,
/// images and patches without noise; whatever `constraints` leaves free is unknown. Image noise is
/// normal and independent. With patches from noisy hosts the grey values of the patch are unknowns
/// too, seen once by the host and once by every other image, and are eliminated: with u = 1/gain,
///
///   F = 1/σ² Σ_n [Σ_v j j' − (Σ_v u j)(Σ_v u j)' / (1 + Σ_v u²)],   rows j divided by the gain.
///
/// Such a point is where it is on the ray through host_uv, which is exact by definition: it is
/// bounded along that ray, in inverse depth, and its covariance contains that of the host.
/// Held points then are held there. Priors do not count. Throws OptionsError, also for
/// noisy patches without host.
CramerRaoBound cramer_rao(const PatchScene& truth,
                          const PatchConstraints& constraints,
                          const CramerRaoOptions& options);

}  // namespace raylign
