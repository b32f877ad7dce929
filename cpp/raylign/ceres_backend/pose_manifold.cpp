// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/pose_manifold.h"

#include "raylign/ceres_backend/pose_blocks.h"
#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/so3.h"

namespace raylign::ceres_backend {
namespace {

using ConstQuaternion = Eigen::Map<const Eigen::Quaterniond>;
using ConstVector3 = Eigen::Map<const Vector3>;

}  // namespace

PoseManifold::PoseManifold(TranslationUpdate update, const PoseMask& mask)
    : update_(update), mask_(mask), tangent_size_(0) {
  for (int i = 0; i < 6; ++i) tangent_size_ += mask_.is_free(i) ? 1 : 0;
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  Eigen::Quaterniond q = ConstQuaternion(x);
  Vector3 t = ConstVector3(x + 4);
  const Vector6 xi =
      pose_embedding(update_, mask_, t) * Eigen::Map<const Eigen::VectorXd>(delta, tangent_size_);
  pose_plus(update_, mask_, xi, q, t);
  Eigen::Map<Eigen::Quaterniond>{x_plus_delta} = q;
  Eigen::Map<Vector3>{x_plus_delta + 4} = t;
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  // d q / d ω = ½ (ω, 0) ⊗ q = ¼ (dφ/dq)ᵀ;  d t / d ξ = [I | −[t]×] or [I | 0].
  RowMajor<7, 6> J = RowMajor<7, 6>::Zero();
  J.topRightCorner<4, 3>() = 0.25 * rotation_d_quaternion(x).transpose();
  J.bottomLeftCorner<3, 3>().setIdentity();
  if (update_ == TranslationUpdate::COUPLED) {
    J.bottomRightCorner<3, 3>() = -so3_hat(ConstVector3(x + 4));
  }
  Eigen::Map<Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::RowMajor>> out(jacobian, 7,
                                                                            tangent_size_);
  if (mask_.any()) {
    out = J * pose_embedding(update_, mask_, ConstVector3(x + 4));
  } else {
    out = J;
  }
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Vector3 omega = quaternion_log(ConstQuaternion(y) * ConstQuaternion(x).conjugate());
  const ConstVector3 t_y(y + 4);
  const ConstVector3 t_x(x + 4);
  Vector6 xi;
  xi.tail<3>() = omega;
  if (update_ == TranslationUpdate::COUPLED) {
    xi.head<3>() = so3_left_jacobian_inverse(omega) * (t_y - quaternion_exp(omega) * t_x);
  } else {
    xi.head<3>() = t_y - t_x;
  }
  for (int i = 0, row = 0; i < 6; ++i) {
    if (mask_.is_free(i)) y_minus_x[row++] = xi[i];
  }
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  RowMajor<6, 7> J = RowMajor<6, 7>::Zero();
  const RowMajor<3, 4> d_omega_d_q = rotation_d_quaternion(x);
  J.bottomLeftCorner<3, 4>() = d_omega_d_q;
  J.topRightCorner<3, 3>().setIdentity();
  if (update_ == TranslationUpdate::COUPLED) {
    J.topLeftCorner<3, 4>() = so3_hat(ConstVector3(x + 4)) * d_omega_d_q;  // υ = dt − ω × t
  }
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>> out(jacobian, tangent_size_,
                                                                            7);
  for (int i = 0, row = 0; i < 6; ++i) {
    if (mask_.is_free(i)) out.row(row++) = J.row(i);
  }
  return true;
}

}  // namespace raylign::ceres_backend
