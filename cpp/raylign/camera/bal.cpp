// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/bal.h"

#include <Eigen/LU>

#include "raylign/camera/check_params.h"
#include "raylign/camera/polynomial_distortion.h"

namespace raylign {

void BalCamera::validate() const {
  require_positive("BalCamera.f", f_);
  require_finite("BalCamera.k1", k1_);
  require_finite("BalCamera.k2", k2_);
}

bool BalCamera::unproject(const Vector2& uv,
                          Vector3& bearing,
                          RowMajor<3, 2>* J_uv,
                          RowMajor<3, kNumParams>* J_params) const {
  PolynomialDistortion distortion;
  distortion.k1 = k1_;
  distortion.k2 = k2_;
  const Vector2 p_distorted = uv / f_;
  Vector2 p;
  RowMajor<2, 2> J_p;
  if (!distortion.undistort(p_distorted, distortion.max_radius_squared(), p, J_p)) return false;
  RowMajor<3, 2> J_bearing;
  bearing = bearing_from_normalized(p, -1.0, &J_bearing);
  // p solves f distort(p; k) = uv:  dp/duv = J_p⁻¹ / f,  dp/dk = −J_p⁻¹ d(distort)/dk.
  const RowMajor<3, 2> J_distorted = J_bearing * J_p.inverse();
  if (J_uv != nullptr) *J_uv = J_distorted / f_;
  if (J_params != nullptr) {
    const double r2 = p.squaredNorm();
    J_params->col(0) = -J_distorted * p_distorted / f_;
    J_params->col(1) = -J_distorted * (r2 * p);
    J_params->col(2) = -J_distorted * (r2 * r2 * p);
  }
  return true;
}

}  // namespace raylign
