// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/sim3.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "raylign/geometry/matrix_phi.h"
#include "raylign/geometry/so3.h"

namespace raylign {
namespace {

// σI + [ω]×, the linear part of sim3_hat.
Matrix3 linear_part(const Vector3& omega, double sigma) {
  return so3_hat(omega) + sigma * Matrix3::Identity();
}

// ad_ξ with ad_ξ η = [ξ, η]: [σI + [ω]× [υ]× −υ; 0 [ω]× 0; 0 0 0].
Matrix7 sim3_ad(const Vector3& upsilon, const Vector3& omega, double sigma) {
  Matrix7 ad = Matrix7::Zero();
  ad.topLeftCorner<3, 3>() = linear_part(omega, sigma);
  ad.block<3, 3>(0, 3) = so3_hat(upsilon);
  ad.block<3, 1>(0, 6) = -upsilon;
  ad.block<3, 3>(3, 3) = so3_hat(omega);
  return ad;
}

}  // namespace

Matrix4 sim3_hat(const Vector7& xi) {
  Matrix4 m = Matrix4::Zero();
  m.topLeftCorner<3, 3>() = linear_part(xi.segment<3>(3), xi[6]);
  m.topRightCorner<3, 1>() = xi.head<3>();
  return m;
}

Vector7 sim3_vee(const Matrix4& xi_hat) {
  const Matrix3 linear = xi_hat.topLeftCorner<3, 3>();
  Vector7 xi;
  xi << xi_hat.topRightCorner<3, 1>(), so3_vee(linear), linear.trace() / 3.0;
  return xi;
}

Matrix4 sim3_exp(const Vector7& xi) {
  const Vector3 omega = xi.segment<3>(3);
  Matrix4 S = Matrix4::Identity();
  S.topLeftCorner<3, 3>() = std::exp(xi[6]) * so3_exp(omega);
  S.topRightCorner<3, 1>() = matrix_phi<3>(linear_part(omega, xi[6])) * xi.head<3>();
  return S;
}

Vector7 sim3_log(const Matrix4& S) {
  const Matrix3 sR = S.topLeftCorner<3, 3>();
  const double determinant = sR.determinant();
  if (!(determinant > 0.0)) return Vector7::Constant(std::numeric_limits<double>::quiet_NaN());
  const double scale = std::cbrt(determinant);
  const Vector3 omega = so3_log(sR / scale);
  const double sigma = std::log(scale);
  const Matrix3 V = matrix_phi<3>(linear_part(omega, sigma));
  Vector7 xi;
  xi << V.partialPivLu().solve(S.topRightCorner<3, 1>()), omega, sigma;
  return xi;
}

Matrix4 sim3_inverse(const Matrix4& S) {
  const Matrix3 sR = S.topLeftCorner<3, 3>();
  const double scale_squared = sR.squaredNorm() / 3.0;
  const Matrix3 inverse_linear = sR.transpose() / scale_squared;
  Matrix4 inverse = Matrix4::Identity();
  inverse.topLeftCorner<3, 3>() = inverse_linear;
  inverse.topRightCorner<3, 1>() = -inverse_linear * S.topRightCorner<3, 1>();
  return inverse;
}

Matrix7 sim3_adjoint(const Matrix4& S) {
  const Matrix3 sR = S.topLeftCorner<3, 3>();
  const Matrix3 R = sR / std::sqrt(sR.squaredNorm() / 3.0);
  const Vector3 t = S.topRightCorner<3, 1>();
  Matrix7 adjoint = Matrix7::Zero();
  adjoint.topLeftCorner<3, 3>() = sR;
  adjoint.block<3, 3>(0, 3) = so3_hat(t) * R;
  adjoint.block<3, 1>(0, 6) = -t;
  adjoint.block<3, 3>(3, 3) = R;
  adjoint(6, 6) = 1.0;
  return adjoint;
}

Matrix7 sim3_left_jacobian(const Vector7& xi) {
  // J_l is linear in υ off the diagonal: a unit υ keeps long translations out of the doubling.
  const double length = xi.head<3>().norm();
  const Vector3 direction = length > 0.0 ? Vector3(xi.head<3>() / length) : Vector3::Zero();
  Matrix7 jacobian = matrix_phi<7>(sim3_ad(direction, xi.segment<3>(3), xi[6]));
  jacobian.topRightCorner<3, 4>() *= length;
  return jacobian;
}

Matrix7 sim3_right_jacobian(const Vector7& xi) { return sim3_left_jacobian(-xi); }

Matrix7 sim3_left_jacobian_inverse(const Vector7& xi) {
  // Block triangular: [A B; 0 D]⁻¹ = [A⁻¹ −A⁻¹ B D⁻¹; 0 D⁻¹], D = diag(J_l(ω), 1).
  const Matrix7 jacobian = sim3_left_jacobian(xi);
  const Matrix3 A_inverse = jacobian.topLeftCorner<3, 3>().inverse();
  Matrix4 D_inverse = Matrix4::Identity();
  D_inverse.topLeftCorner<3, 3>() = so3_left_jacobian_inverse(xi.segment<3>(3));
  Matrix7 inverse = Matrix7::Zero();
  inverse.topLeftCorner<3, 3>() = A_inverse;
  inverse.topRightCorner<3, 4>() = -A_inverse * jacobian.topRightCorner<3, 4>() * D_inverse;
  inverse.bottomRightCorner<4, 4>() = D_inverse;
  return inverse;
}

Matrix7 sim3_right_jacobian_inverse(const Vector7& xi) { return sim3_left_jacobian_inverse(-xi); }

}  // namespace raylign
