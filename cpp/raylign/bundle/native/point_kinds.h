// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/kernel_math.h"

/// What the kernels ask of a point x = (x̄, w): the ray a = x̄ − w c, the tangent E = ∂r/∂δ, and the
/// point after a step δ. One overload for each kind, chosen by a tag: XYZ compiles to what it would
/// be without them. Points, camera centres and translations are in one frame (CameraBlocks).
namespace raylign::native {

struct XyzPoint {
  static constexpr int kStride = 3;
};

/// [x̃; w̃] on the unit sphere.
struct HomogeneousPoint {
  static constexpr int kStride = 4;
};

/// The Householder vector of SphereTangent (parametrization/homogeneous.h), v[3] = 1.
struct Householder {
  double v[3];
  double beta;
};

RAYLIGN_INLINE double weight(XyzPoint /*kind*/, const double* /*X*/) { return 1.0; }
RAYLIGN_INLINE double weight(HomogeneousPoint /*kind*/, const double* X) { return X[3]; }

template <typename Point>
RAYLIGN_INLINE void ray(Point kind, const double* X, const double* c, double* a) {
  const double w = weight(kind, X);
  for (int k = 0; k < 3; ++k) a[k] = X[k] - w * c[k];
}

// P = R x̄ + w t.
template <typename Point>
RAYLIGN_INLINE void transform(Point kind, const CameraPacket& camera, const double* X, double* P) {
  const double w = weight(kind, X);
  for (int k = 0; k < 3; ++k) P[k] = dot3(camera.R + 3 * k, X) + w * camera.t[k];
}

RAYLIGN_INLINE Householder tangent_at(XyzPoint /*kind*/, const double* /*X*/) { return {}; }
RAYLIGN_INLINE Householder tangent_at(HomogeneousPoint /*kind*/, const double* X) {
  Householder H = {{X[0], X[1], X[2]}, X[3] < 0.0 ? 2.0 : 0.0};
  const double sigma = dot3(X, X);
  if (sigma <= std::numeric_limits<double>::epsilon()) return H;
  const double mu = std::sqrt(X[3] * X[3] + sigma);
  const double pivot = X[3] <= 0.0 ? X[3] - mu : -sigma / (X[3] + mu);
  H.beta = 2.0 * pivot * pivot / (sigma + pivot * pivot);
  for (int k = 0; k < 3; ++k) H.v[k] /= pivot;
  return H;
}

// E = ∂r/∂δ, two rows of three, from A = ∂r/∂x̄ and ∂r/∂w = −A c: A itself, or
// A (B_xyz − c b_wᵀ) = ½ (A − β A (v − c) vᵀ) with the basis B = ½ (I − β v vᵀ) of the tangent.
RAYLIGN_INLINE void point_rows(
    XyzPoint /*kind*/, const Householder& /*H*/, const double* A, const double* /*c*/, double* E) {
  for (int k = 0; k < 6; ++k) E[k] = A[k];
}
RAYLIGN_INLINE void point_rows(
    HomogeneousPoint /*kind*/, const Householder& H, const double* A, const double* c, double* E) {
  const double n[3] = {H.v[0] - c[0], H.v[1] - c[1], H.v[2] - c[2]};
  for (int row = 0; row < 6; row += 3) {
    const double d = H.beta * dot3(A + row, n);
    for (int k = 0; k < 3; ++k) E[row + k] = 0.5 * (A[row + k] - d * H.v[k]);
  }
}

RAYLIGN_INLINE void move_point(XyzPoint /*kind*/,
                               const Householder& /*H*/,
                               const double* X,
                               const double* step,
                               double* X_trial) {
  for (int k = 0; k < 3; ++k) X_trial[k] = X[k] + step[k];
}
RAYLIGN_INLINE void move_point(HomogeneousPoint /*kind*/,
                               const Householder& H,
                               const double* X,
                               const double* step,
                               double* X_trial) {
  const double half = 0.5 * std::sqrt(dot3(step, step));
  if (half == 0.0) {  // a held point keeps its bits
    for (int k = 0; k < 4; ++k) X_trial[k] = X[k];
    return;
  }
  const double scale = 0.5 * std::sin(half) / half;
  const double y[3] = {scale * step[0], scale * step[1], scale * step[2]};
  const double y_w = std::cos(half);
  const double d = H.beta * (dot3(H.v, y) + y_w);
  for (int k = 0; k < 3; ++k) X_trial[k] = y[k] - d * H.v[k];
  X_trial[3] = y_w - d;
}

}  // namespace raylign::native
