// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/manifold.h>

#include <array>

#include "raylign/base/eigen.h"

namespace raylign::ceres_backend {

/// Tangent [υ; ω] of the pose block [q (xyzw), t]; the rotation moves as R ← Exp(ω) R in both.
enum class TranslationUpdate {
  COUPLED,   ///< SE(3): T ← exp(ξ) T, so t ← Exp(ω) t + J_l(ω) υ
  ADDITIVE,  ///< t ← t + υ
};

/// What of a pose is held constant; it is held exactly, not to first order.
struct PoseMask {
  std::array<bool, 3> translation{false, false, false};
  bool rotation = false;

  bool any() const { return rotation || translation[0] || translation[1] || translation[2]; }
};

/// Ceres manifold of a camera pose. Held coordinates leave the tangent space: with COUPLED a held
/// t_k asks υ_k = −(ω × t)_k of the tangent vector, and Plus puts the very same t_k back.
class PoseManifold final : public ceres::Manifold {
 public:
  explicit PoseManifold(TranslationUpdate update, const PoseMask& mask = {});

  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return tangent_size_; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  using Embedding = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

  /// Full tangent ξ = E δ of the free coordinates δ at x.
  Embedding embedding(const double* x) const;
  bool is_free(int tangent_index) const {
    return tangent_index < 3 ? !mask_.translation[tangent_index] : !mask_.rotation;
  }

  TranslationUpdate update_;
  PoseMask mask_;
  int tangent_size_;
};

}  // namespace raylign::ceres_backend
