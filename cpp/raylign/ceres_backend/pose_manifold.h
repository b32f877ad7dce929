// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/manifold.h>

#include "raylign/parametrization/pose_update.h"

namespace raylign::ceres_backend {

/// Ceres manifold of a camera pose, tangent [υ; ω] of the block [q (xyzw), t]: pose_plus and
/// pose_embedding behind Ceres' interface.
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
  TranslationUpdate update_;
  PoseMask mask_;
  int tangent_size_;
};

}  // namespace raylign::ceres_backend
