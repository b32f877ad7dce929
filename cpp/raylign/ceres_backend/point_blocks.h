// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/parametrization/homogeneous.h"

/// How a point is stored in a Ceres parameter block. Each reads as a homogeneous point (x̄, w) of
/// the world, so that p_c = R x̄ + w t, and turns ∂r/∂x̄ and ∂r/∂w into the Jacobian of its own
/// numbers.
namespace raylign::ceres_backend {

/// (X, Y, Z).
struct XyzPoint {
  static constexpr int kSize = 3;
  Vector3 x_bar(const double* block) const { return {block[0], block[1], block[2]}; }
  double w(const double* /*block*/) const { return 1.0; }
  void write_jacobian(const RowMajor<2, 3>& J_x, const Vector2& /*J_w*/, double* out) const {
    Eigen::Map<RowMajor<2, kSize>>{out} = J_x;
  }
};

/// [x̃; w̃] on the unit sphere of R⁴ (Triggs et al. 2000, §2.2); w̃ may reach and cross zero.
class HomogeneousPoint {
 public:
  static constexpr int kSize = 4;

  /// `frame` must outlive the point.
  explicit HomogeneousPoint(const HomogeneousFrame& frame) : frame_(&frame) {}

  Vector3 x_bar(const double* block) const {
    return frame_->scale * Vector3(block[0], block[1], block[2]) + block[3] * frame_->center;
  }
  double w(const double* block) const { return block[3]; }
  void write_jacobian(const RowMajor<2, 3>& J_x, const Vector2& J_w, double* out) const {
    Eigen::Map<RowMajor<2, kSize>> J(out);
    J.leftCols<3>() = frame_->scale * J_x;
    J.col(3) = J_x * frame_->center + J_w;
  }

 private:
  const HomogeneousFrame* frame_;
};

}  // namespace raylign::ceres_backend
