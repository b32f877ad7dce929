// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/patch/patch_solve_options.h"
#include "raylign/robust/loss.h"

namespace raylign {

struct NoiseLawOptions {
  /// σ of one pixel that the sensor is known to have, grey; no fitted σ is smaller. Nor is one
  /// smaller than half a grey level, so that exact images do not make every weight huge.
  double sensor_sigma = 0.0;
  double nu = 0.0;  ///< degrees of freedom of Student's t; 0: fitted

  /// Throws OptionsError: finite and >= 0, each.
  void validate() const;
};

/// How residuals of one pixel scatter: a robust standard deviation, which is all that Huber's and
/// Cauchy's laws need, and Student's t.
struct NoiseLaw {
  double sigma = 0.5;              ///< 1.4826 median |r|, grey: σ if the residuals were normal
  double t_scale = 0.5;            ///< σ_t of Student's t, grey
  double nu = 30.0;                ///< ν of Student's t, in [1, 30] when fitted
  double log_likelihood = 0.0;     ///< of Student's t, nats per residual
  std::int64_t num_residuals = 0;  ///< residuals that were fitted; 0: σ is the floor

  /// Variance of a location estimate from one residual, (ν + 3) / (ν + 1) σ_t²: the inverse of the
  /// Fisher information of Student's t (Lange, Little, Taylor, JASA 1989, appendix B).
  double variance() const { return (nu + 3.0) / (nu + 1.0) * t_scale * t_scale; }
};

/// Fits to residuals in grey levels: those of unmasked pixels of edges that are seen. Edges that
/// show a patch its own host image do not belong to them: both have the same noise. ν and σ_t by
/// maximum likelihood: σ_t for each ν of a grid of 35 steps of 10 %, in a histogram whose bins are
/// 1.6 % wide. The order of the residuals changes nothing. Residuals that are not finite are left
/// out. Throws OptionsError.
NoiseLaw fit_noise_law(const std::vector<float>& residuals, const NoiseLawOptions& options = {});

/// The loss that belongs to a law of noise. For single pixels: STUDENT_T with its
/// maximum-likelihood parameters; HUBER at 1.345 σ and CAUCHY at 2.385 σ, which keep 95 % of the
/// efficiency on normal noise; TRIVIAL. For whole patches HUBER at √χ²(n, 0.95) σ, below which 95 %
/// of the patches of n pixels lie; the others as for single pixels times √n. Throws OptionsError
/// for another type.
Loss noise_loss(const NoiseLaw& law, LossType type, LossScope scope, int num_pixels);

}  // namespace raylign
