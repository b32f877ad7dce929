// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/quaternion.h"

#include <cmath>

namespace raylign {

Quaternion quaternion_exp(const Vector3& omega) {
  const double theta = omega.norm();
  const double scale = theta == 0.0 ? 0.5 : std::sin(theta / 2.0) / theta;
  const Vector3 v = scale * omega;
  return Quaternion(std::cos(theta / 2.0), v.x(), v.y(), v.z());
}

Vector3 quaternion_log(const Quaternion& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * q.w();
  const double n = q.vec().norm();
  // atan2 needs no unit norm and is accurate at both ends, 0 and π. n == 0: atan(n / w) → n / w.
  const double scale = n == 0.0 ? 2.0 / w : 2.0 * std::atan2(n, w) / n;
  return sign * scale * q.vec();
}

Matrix3 quaternion_to_matrix(const Quaternion& q) { return q.normalized().toRotationMatrix(); }

Quaternion quaternion_from_matrix(const Matrix3& R) {
  Quaternion q(R);  // Eigen implements Shepperd's four cases
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q;
}

}  // namespace raylign
