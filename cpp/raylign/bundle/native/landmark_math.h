// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "raylign/base/clones.h"
#include "raylign/base/double_lanes.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/robust/loss.h"

/// What an observation adds to its landmark, and the landmark's own 3×3 system. Numbers are double,
/// or D4 with four landmarks side by side; masks bool or M4.

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

// The same for four observations.
RAYLIGN_INLINE void apply_loss(const Loss& loss, JacobianOf<D4>& J, D4* r, D4& rho) {
  const D4 s = rho;
  D4 weight;
  for (int lane = 0; lane < 4; ++lane) {
    const LossValue value = loss.evaluate(s[lane]);
    weight[lane] = std::sqrt(value.d_rho);
    rho[lane] = value.rho;
  }
  for (int k = 0; k < 6; ++k) J.A[k] *= weight;
  for (int k = 0; k < 6; ++k) J.I[k] *= weight;
  r[0] *= weight;
  r[1] *= weight;
}

template <typename T>
RAYLIGN_INLINE void add_gradient(const T* A, const T* r, LandmarkBlockOf<T>& block) {
  for (int k = 0; k < 3; ++k) block.g[k] += A[k] * r[0] + A[3 + k] * r[1];
}

template <typename T>
RAYLIGN_INLINE void add_hessian(const T* A, LandmarkBlockOf<T>& block) {
  const T* b = A + 3;
  block.H[0] += A[0] * A[0] + b[0] * b[0];
  block.H[1] += A[0] * A[1] + b[0] * b[1];
  block.H[2] += A[0] * A[2] + b[0] * b[2];
  block.H[3] += A[1] * A[1] + b[1] * b[1];
  block.H[4] += A[1] * A[2] + b[1] * b[2];
  block.H[5] += A[2] * A[2] + b[2] * b[2];
}

// W = L⁻ᵀ, L Lᵀ = H with `diagonal` in place of its own. A held coordinate is eliminated as if it
// stood alone, then its row and column are struck out. All zero where a pivot is not positive:
// the landmark stays this time.
template <typename T, typename Mask>
RAYLIGN_INLINE void factor_block(const T* H, const T* diagonal, const Mask* held, T* W) {
  const T zero = {};
  const T one = zero + 1.0;
  const Mask hx = held[0];
  const Mask hy = held[1];
  const Mask hz = held[2];
  const T xx = hx ? one : diagonal[0];
  const T xy = (hx | hy) ? zero : H[1];
  const T xz = (hx | hz) ? zero : H[2];
  const T yy = hy ? one : diagonal[1];
  const T yz = (hy | hz) ? zero : H[4];
  const T zz = hz ? one : diagonal[2];
  T root;
  square_root(xx, root);
  const T w_x = 1.0 / root;
  const T l_yx = xy * w_x;
  const T l_zx = xz * w_x;
  square_root(yy - l_yx * l_yx, root);
  const T w_y = 1.0 / root;
  const T l_zy = (yz - l_zx * l_yx) * w_y;
  square_root(zz - l_zx * l_zx - l_zy * l_zy, root);
  const T w_z = 1.0 / root;
  const T w_yz = -l_zy * w_y * w_z;
  const T sum = w_x + w_y + w_z;
  const Mask is_finite = sum - sum == zero;  // neither NaN nor ∞, which such pivots give
  W[0] = hx ? zero : (is_finite ? w_x : zero);
  W[1] = is_finite ? -l_yx * w_x * w_y : zero;
  W[2] = is_finite ? -(l_zx * w_z + l_yx * w_yz) * w_x : zero;
  W[3] = hy ? zero : (is_finite ? w_y : zero);
  W[4] = is_finite ? w_yz : zero;
  W[5] = hz ? zero : (is_finite ? w_z : zero);
}

}  // namespace raylign::native
