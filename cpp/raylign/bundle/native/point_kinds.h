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
/// Numbers are double, or D4 with four points side by side.
namespace raylign::native {

struct XyzPoint {
  static constexpr int kStride = 3;
};

/// [x̃; w̃] on the unit sphere.
struct HomogeneousPoint {
  static constexpr int kStride = 4;
};

/// The Householder vector of SphereTangent (parametrization/homogeneous.h), v[3] = 1.
template <typename T>
struct Householder {
  T v[3];
  T beta;
};

template <typename T>
RAYLIGN_INLINE T weight(XyzPoint /*kind*/, const T* /*X*/) {
  return T{} + 1.0;
}
template <typename T>
RAYLIGN_INLINE T weight(HomogeneousPoint /*kind*/, const T* X) {
  return X[3];
}

template <typename T>
RAYLIGN_INLINE void ray(XyzPoint /*kind*/, const T* X, const T* c, T* a) {
  for (int k = 0; k < 3; ++k) a[k] = X[k] - c[k];
}
template <typename T>
RAYLIGN_INLINE void ray(HomogeneousPoint /*kind*/, const T* X, const T* c, T* a) {
  for (int k = 0; k < 3; ++k) a[k] = X[k] - X[3] * c[k];
}

// P = R x̄ + w t.
template <typename Camera, typename T>
RAYLIGN_INLINE void transform(XyzPoint /*kind*/, const Camera& camera, const T* X, T* P) {
  for (int k = 0; k < 3; ++k) P[k] = dot3(camera.R + 3 * k, X) + camera.t[k];
}
template <typename Camera, typename T>
RAYLIGN_INLINE void transform(HomogeneousPoint /*kind*/, const Camera& camera, const T* X, T* P) {
  for (int k = 0; k < 3; ++k) P[k] = dot3(camera.R + 3 * k, X) + X[3] * camera.t[k];
}

template <typename T>
RAYLIGN_INLINE Householder<T> tangent_at(XyzPoint /*kind*/, const T* /*X*/) {
  const Householder<T> none = {};
  return none;
}
RAYLIGN_INLINE Householder<double> tangent_at(HomogeneousPoint /*kind*/, const double* X) {
  Householder<double> H = {{X[0], X[1], X[2]}, X[3] < 0.0 ? 2.0 : 0.0};
  const double sigma = dot3(X, X);
  if (sigma <= std::numeric_limits<double>::epsilon()) return H;
  const double mu = std::sqrt(X[3] * X[3] + sigma);
  const double pivot = X[3] <= 0.0 ? X[3] - mu : -sigma / (X[3] + mu);
  H.beta = 2.0 * pivot * pivot / (sigma + pivot * pivot);
  for (int k = 0; k < 3; ++k) H.v[k] /= pivot;
  return H;
}
RAYLIGN_INLINE Householder<D4> tangent_at(HomogeneousPoint kind, const D4* X) {
  Householder<D4> tangents;
  for (int lane = 0; lane < 4; ++lane) {
    const double x[4] = {X[0][lane], X[1][lane], X[2][lane], X[3][lane]};
    const Householder<double> H = tangent_at(kind, x);
    for (int k = 0; k < 3; ++k) tangents.v[k][lane] = H.v[k];
    tangents.beta[lane] = H.beta;
  }
  return tangents;
}

// E = ∂r/∂δ, two rows of three, from A = ∂r/∂x̄ and ∂r/∂w = −A c: A itself, or
// A (B_xyz − c b_wᵀ) = ½ (A − β A (v − c) vᵀ) with the basis B = ½ (I − β v vᵀ) of the tangent.
template <typename T>
RAYLIGN_INLINE void point_rows(
    XyzPoint /*kind*/, const Householder<T>& /*H*/, const T* A, const T* /*c*/, T* E) {
  for (int k = 0; k < 6; ++k) E[k] = A[k];
}
template <typename T>
RAYLIGN_INLINE void point_rows(
    HomogeneousPoint /*kind*/, const Householder<T>& H, const T* A, const T* c, T* E) {
  const T n[3] = {H.v[0] - c[0], H.v[1] - c[1], H.v[2] - c[2]};
  for (int row = 0; row < 6; row += 3) {
    const T d = H.beta * dot3(A + row, n);
    for (int k = 0; k < 3; ++k) E[row + k] = 0.5 * (A[row + k] - d * H.v[k]);
  }
}

template <typename T>
RAYLIGN_INLINE void move_point(
    XyzPoint /*kind*/, const Householder<T>& /*H*/, const T* X, const T* step, T* X_trial) {
  for (int k = 0; k < 3; ++k) X_trial[k] = X[k] + step[k];
}
RAYLIGN_INLINE void move_point(HomogeneousPoint /*kind*/,
                               const Householder<double>& H,
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
RAYLIGN_INLINE void move_point(HomogeneousPoint kind,
                               const Householder<D4>& tangents,
                               const D4* X,
                               const D4* steps,
                               D4* X_trial) {
  for (int lane = 0; lane < 4; ++lane) {
    const double x[4] = {X[0][lane], X[1][lane], X[2][lane], X[3][lane]};
    const double step[3] = {steps[0][lane], steps[1][lane], steps[2][lane]};
    const Householder<double> H = {{tangents.v[0][lane], tangents.v[1][lane], tangents.v[2][lane]},
                                   tangents.beta[lane]};
    double moved[4];
    move_point(kind, H, x, step, moved);
    for (int k = 0; k < 4; ++k) X_trial[k][lane] = moved[k];
  }
}

}  // namespace raylign::native
