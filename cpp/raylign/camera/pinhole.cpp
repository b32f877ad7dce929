// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/pinhole.h"

#include <cmath>

#include "raylign/base/error.h"
#include "raylign/camera/bearing.h"
#include "raylign/camera/check_params.h"

namespace raylign {

Matrix3 PinholeCamera::matrix() const {
  Matrix3 K;
  K << fx_, 0.0, cx_,  //
      0.0, fy_, cy_,   //
      0.0, 0.0, 1.0;
  return K;
}

void PinholeCamera::validate() const {
  require_positive("PinholeCamera.fx", fx_);
  require_positive("PinholeCamera.fy", fy_);
  require_finite("PinholeCamera.cx", cx_);
  require_finite("PinholeCamera.cy", cy_);
}

PinholeCamera PinholeCamera::at_level(int level) const {
  require_option(level >= 0, "level", ">= 0", level);
  const double scale = std::ldexp(1.0, -level);
  return {fx_ * scale, fy_ * scale, (cx_ + 0.5) * scale - 0.5, (cy_ + 0.5) * scale - 0.5};
}

bool PinholeCamera::project(const Vector3& p_c,
                            Vector2& uv,
                            RowMajor<2, 3>* J_point,
                            RowMajor<2, kNumParams>* J_params) const {
  if (!(p_c.z() >= kMinDepth)) return false;
  const double inverse_z = 1.0 / p_c.z();
  const double x = p_c.x() * inverse_z;
  const double y = p_c.y() * inverse_z;
  uv = Vector2(fx_ * x + cx_, fy_ * y + cy_);
  if (J_point != nullptr) {
    *J_point << fx_ * inverse_z, 0.0, -fx_ * x * inverse_z,  //
        0.0, fy_ * inverse_z, -fy_ * y * inverse_z;
  }
  if (J_params != nullptr) {
    *J_params << x, 0.0, 1.0, 0.0,  //
        0.0, y, 0.0, 1.0;
  }
  return uv.allFinite();
}

bool PinholeCamera::unproject(const Vector2& uv,
                              Vector3& bearing,
                              RowMajor<3, 2>* J_uv,
                              RowMajor<3, kNumParams>* J_params) const {
  if (!uv.allFinite()) return false;
  const Vector2 p((uv.x() - cx_) / fx_, (uv.y() - cy_) / fy_);
  RowMajor<3, 2> J_bearing;
  bearing = bearing_from_normalized(p, 1.0, &J_bearing);
  const Vector3 J_u = J_bearing.col(0) / fx_;
  const Vector3 J_v = J_bearing.col(1) / fy_;
  if (J_uv != nullptr) *J_uv << J_u, J_v;
  if (J_params != nullptr) *J_params << -J_u * p.x(), -J_v * p.y(), -J_u, -J_v;
  return true;
}

}  // namespace raylign
