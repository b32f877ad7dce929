// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

/// How a point is stored in a Ceres parameter block. Each reads as a homogeneous point (x̄, w), so
/// that p_c = R x̄ + w t, and turns ∂r/∂x̄ and ∂r/∂w into the Jacobian of its own numbers.
namespace raylign::ceres_backend {

/// (X, Y, Z).
struct XyzPoint {
  static constexpr int kSize = 3;
  static Vector3 x_bar(const double* block) { return {block[0], block[1], block[2]}; }
  static double w(const double* /*block*/) { return 1.0; }
  static void write_jacobian(const RowMajor<2, 3>& J_x, const Vector2& /*J_w*/, double* out) {
    Eigen::Map<RowMajor<2, kSize>>{out} = J_x;
  }
};

/// [x̄; w] on the unit sphere of R⁴ (Triggs et al. 2000, §2.2); w may reach and cross zero.
struct HomogeneousPoint {
  static constexpr int kSize = 4;
  static Vector3 x_bar(const double* block) { return {block[0], block[1], block[2]}; }
  static double w(const double* block) { return block[3]; }
  static void write_jacobian(const RowMajor<2, 3>& J_x, const Vector2& J_w, double* out) {
    Eigen::Map<RowMajor<2, kSize>> J(out);
    J.leftCols<3>() = J_x;
    J.col(3) = J_w;
  }
};

}  // namespace raylign::ceres_backend
