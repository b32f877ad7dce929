// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/se3.h"

#include "raylign/geometry/so3.h"
#include "raylign/geometry/stumpff.h"

namespace raylign {
namespace {

// Q(υ, ω), the derivative of J_l(ω) υ by ω up to a left Jacobian. Barfoot eq. (7.86).
Matrix3 left_jacobian_coupling(const Vector6& xi) {
  const Matrix3 P = so3_hat(xi.head<3>());
  const Matrix3 W = so3_hat(xi.tail<3>());
  const Stumpff c = stumpff(xi.tail<3>().squaredNorm());
  const Matrix3 WP = W * P;
  const Matrix3 PW = P * W;
  const Matrix3 WPW = WP * W;
  return 0.5 * P + c.c3 * (WP + PW + WPW) + c.c4 * (W * WP + PW * W - 3.0 * WPW) +
         0.5 * (c.c4 - 3.0 * c.c5) * (WPW * W + W * WPW);
}

}  // namespace

Matrix4 se3_hat(const Vector6& xi) {
  Matrix4 m = Matrix4::Zero();
  m.topLeftCorner<3, 3>() = so3_hat(xi.tail<3>());
  m.topRightCorner<3, 1>() = xi.head<3>();
  return m;
}

Vector6 se3_vee(const Matrix4& xi_hat) {
  Vector6 xi;
  xi << xi_hat.topRightCorner<3, 1>(), so3_vee(xi_hat.topLeftCorner<3, 3>());
  return xi;
}

Matrix4 se3_exp(const Vector6& xi) {
  Matrix4 T = Matrix4::Identity();
  T.topLeftCorner<3, 3>() = so3_exp(xi.tail<3>());
  T.topRightCorner<3, 1>() = so3_left_jacobian(xi.tail<3>()) * xi.head<3>();
  return T;
}

Vector6 se3_log(const Matrix4& T) {
  const Vector3 omega = so3_log(T.topLeftCorner<3, 3>());
  Vector6 xi;
  xi << so3_left_jacobian_inverse(omega) * T.topRightCorner<3, 1>(), omega;
  return xi;
}

Matrix4 se3_inverse(const Matrix4& T) {
  const Matrix3 R_inverse = T.topLeftCorner<3, 3>().transpose();
  Matrix4 inverse = Matrix4::Identity();
  inverse.topLeftCorner<3, 3>() = R_inverse;
  inverse.topRightCorner<3, 1>() = -R_inverse * T.topRightCorner<3, 1>();
  return inverse;
}

Matrix6 se3_adjoint(const Matrix4& T) {
  const Matrix3 R = T.topLeftCorner<3, 3>();
  Matrix6 adjoint;
  adjoint << R, so3_hat(T.topRightCorner<3, 1>()) * R,  //
      Matrix3::Zero(), R;
  return adjoint;
}

Matrix6 se3_left_jacobian(const Vector6& xi) {
  const Matrix3 J = so3_left_jacobian(xi.tail<3>());
  Matrix6 jacobian;
  jacobian << J, left_jacobian_coupling(xi),  //
      Matrix3::Zero(), J;
  return jacobian;
}

Matrix6 se3_right_jacobian(const Vector6& xi) { return se3_left_jacobian(-xi); }

Matrix6 se3_left_jacobian_inverse(const Vector6& xi) {
  const Matrix3 J_inverse = so3_left_jacobian_inverse(xi.tail<3>());
  Matrix6 inverse;
  inverse << J_inverse, -J_inverse * left_jacobian_coupling(xi) * J_inverse,  //
      Matrix3::Zero(), J_inverse;
  return inverse;
}

Matrix6 se3_right_jacobian_inverse(const Vector6& xi) { return se3_left_jacobian_inverse(-xi); }

}  // namespace raylign
