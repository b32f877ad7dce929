// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/robust/loss.h"

/// What an observation adds to its landmark, and the landmark's own 3×3 system.

namespace raylign::native {

// Multiplies J and r by √ρ′ and returns ρ.
RAYLIGN_INLINE double apply_loss(const Loss& loss, double s, ObservationJacobian& J, double* r) {
  const LossValue value = loss.evaluate(s);
  const double weight = std::sqrt(value.d_rho);
  for (int k = 0; k < 6; ++k) J.A[k] *= weight;
  for (int k = 0; k < 6; ++k) J.I[k] *= weight;
  r[0] *= weight;
  r[1] *= weight;
  return value.rho;
}

RAYLIGN_INLINE void add_gradient(const double* A, const double* r, LandmarkBlock& block) {
  for (int k = 0; k < 3; ++k) block.g[k] += A[k] * r[0] + A[3 + k] * r[1];
}

RAYLIGN_INLINE void add_hessian(const double* A, LandmarkBlock& block) {
  const double* b = A + 3;
  block.H[0] += A[0] * A[0] + b[0] * b[0];
  block.H[1] += A[0] * A[1] + b[0] * b[1];
  block.H[2] += A[0] * A[2] + b[0] * b[2];
  block.H[3] += A[1] * A[1] + b[1] * b[1];
  block.H[4] += A[1] * A[2] + b[1] * b[2];
  block.H[5] += A[2] * A[2] + b[2] * b[2];
}

// W = L⁻ᵀ, L Lᵀ = H with `diagonal` in place of its own. A held coordinate is eliminated as if it
// stood alone, then its row and column are struck out. All zero where a pivot is not positive.
RAYLIGN_INLINE LandmarkFactor factor_block(const double* H,
                                           const double* diagonal,
                                           const bool* held) {
  const bool hx = held[0];
  const bool hy = held[1];
  const bool hz = held[2];
  const double xx = hx ? 1.0 : diagonal[0];
  const double xy = hx || hy ? 0.0 : H[1];
  const double xz = hx || hz ? 0.0 : H[2];
  const double yy = hy ? 1.0 : diagonal[1];
  const double yz = hy || hz ? 0.0 : H[4];
  const double zz = hz ? 1.0 : diagonal[2];
  const double w_x = 1.0 / std::sqrt(xx);
  const double l_yx = xy * w_x;
  const double l_zx = xz * w_x;
  const double w_y = 1.0 / std::sqrt(yy - l_yx * l_yx);
  const double l_zy = (yz - l_zx * l_yx) * w_y;
  const double w_z = 1.0 / std::sqrt(zz - l_zx * l_zx - l_zy * l_zy);
  // NaN and ∞ where a pivot is not positive: the landmark stays this time
  if (!(std::isfinite(w_x) && std::isfinite(w_y) && std::isfinite(w_z))) return {};
  const double w_yz = -l_zy * w_y * w_z;
  return {{hx ? 0.0 : w_x, -l_yx * w_x * w_y, -(l_zx * w_z + l_yx * w_yz) * w_x, hy ? 0.0 : w_y,
           w_yz, hz ? 0.0 : w_z}};
}

}  // namespace raylign::native
