// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/warp.h"

#include <Eigen/LU>
#include <cmath>

namespace raylign::photometric {

double PlaneWarp::scale() const { return std::sqrt(std::abs(A.determinant())); }

PlaneWarp plane_warp(const Matrix3& R_jh,
                     const Vector3& t_jh,
                     const Vector3& ray,
                     double depth,
                     const Vector3& normal,
                     const Vector4& K_h,
                     const Vector4& K_j) {
  PlaneWarp warp;
  const Vector3 q = depth * (R_jh * ray) + t_jh;
  const double facing_h = normal.dot(ray);
  const double facing_j = (R_jh * normal).dot(q);
  if (!(depth > 0.0 && q.z() > 0.0 && facing_h * facing_j > 0.0)) return warp;
  RowMajor<2, 3> P;
  P << K_j[0] / q.z(), 0.0, -K_j[0] * q.x() / (q.z() * q.z()),  //
      0.0, K_j[1] / q.z(), -K_j[1] * q.y() / (q.z() * q.z());
  for (int i = 0; i < 2; ++i) {
    // How the point on the plane moves per px of the host.
    const Vector3 step = (Vector3::Unit(i) - ray * (normal[i] / facing_h)) * (depth / K_h[i]);
    warp.A.col(i) = P * (R_jh * step);
  }
  warp.cos_view = std::abs(facing_j) / (normal.norm() * q.norm());
  warp.is_valid = warp.A.allFinite() && warp.A.determinant() > 0.0;
  return warp;
}

}  // namespace raylign::photometric
