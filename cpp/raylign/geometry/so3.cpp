// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/so3.h"

#include <cmath>

#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/stumpff.h"

namespace raylign {
namespace {

// a I + b [ω]× + c ([ω]×)², the form of every function of [ω]×; ([ω]×)² = ω ωᵀ − ‖ω‖² I. Written
// out, because it stands in the innermost loop of bundle adjustment.
Matrix3 polynomial(const Vector3& omega, double a, double b, double c) {
  const double x = omega.x();
  const double y = omega.y();
  const double z = omega.z();
  const double d = a - c * (x * x + y * y + z * z);
  const double cxy = c * x * y;
  const double cxz = c * x * z;
  const double cyz = c * y * z;
  Matrix3 m;
  m << d + c * x * x, cxy - b * z, cxz + b * y,  //
      cxy + b * z, d + c * y * y, cyz - b * x,   //
      cxz - b * y, cyz + b * x, d + c * z * z;
  return m;
}

struct Coefficients {
  double c1;  // sin θ / θ
  double c2;  // (1 − cos θ) / θ²
};

// 1 − cos θ = 2 sin²(θ/2) does not cancel, so no series is needed near 0.
Coefficients exp_coefficients(double theta_squared) {
  const double theta = std::sqrt(theta_squared);
  if (theta == 0.0) return {1.0, 0.5};
  const double half_sine = std::sin(theta / 2.0) / theta;
  return {2.0 * half_sine * std::cos(theta / 2.0), 2.0 * half_sine * half_sine};
}

}  // namespace

Matrix3 so3_hat(const Vector3& omega) {
  Matrix3 m;
  m << 0.0, -omega.z(), omega.y(),  //
      omega.z(), 0.0, -omega.x(),   //
      -omega.y(), omega.x(), 0.0;
  return m;
}

Vector3 so3_vee(const Matrix3& omega_hat) {
  const Matrix3& m = omega_hat;
  return 0.5 * Vector3(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
}

Matrix3 so3_exp(const Vector3& omega) {
  const Coefficients c = exp_coefficients(omega.squaredNorm());
  return polynomial(omega, 1.0, c.c1, c.c2);
}

Matrix3 so3_exp_and_left_jacobian(const Vector3& omega, Matrix3& J_left) {
  const double theta_squared = omega.squaredNorm();
  const Coefficients c = exp_coefficients(theta_squared);
  // 1 − c1 cancels near 0, but c3 only ever meets ([ω]×)² ~ θ²: the product is off by one ulp of J.
  const double c3 = theta_squared > 0.0 ? (1.0 - c.c1) / theta_squared : 0.0;
  J_left = polynomial(omega, 1.0, c.c2, c3);
  return polynomial(omega, 1.0, c.c1, c.c2);
}

Vector3 so3_log(const Matrix3& R) { return quaternion_log(quaternion_from_matrix(R)); }

Matrix3 so3_left_jacobian(const Vector3& omega) {
  const Stumpff c = stumpff(omega.squaredNorm());
  return polynomial(omega, 1.0, c.c2, c.c3);
}

Matrix3 so3_right_jacobian(const Vector3& omega) { return so3_left_jacobian(-omega); }

Matrix3 so3_left_jacobian_inverse(const Vector3& omega) {
  const Stumpff c = stumpff(omega.squaredNorm());
  // (1 − θ/2 cot(θ/2)) / θ², Barfoot eq. (7.76), rewritten so that nothing cancels near 0.
  return polynomial(omega, 1.0, -0.5, (0.5 * c.c3 - c.c4) / c.c2);
}

Matrix3 so3_right_jacobian_inverse(const Vector3& omega) {
  return so3_left_jacobian_inverse(-omega);
}

Matrix3 so3_adjoint(const Matrix3& R) { return R; }

}  // namespace raylign
