// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/radtan.h"

#include <Eigen/LU>

#include "raylign/camera/bearing.h"
#include "raylign/camera/check_params.h"

namespace raylign {

RadtanCamera::RadtanCamera(const PinholeCamera& pinhole, const PolynomialDistortion& distortion)
    : pinhole_(pinhole),
      distortion_(distortion),
      max_radius_squared_(distortion.max_radius_squared()) {}

RadtanCamera::RadtanCamera(const Params& params)
    : RadtanCamera(PinholeCamera(params.head<4>()),
                   {params[4], params[5], params[6], params[7], params[8]}) {}

RadtanCamera::Params RadtanCamera::params() const {
  const PolynomialDistortion& d = distortion_;
  Params params;
  params << pinhole_.params(), d.k1, d.k2, d.p1, d.p2, d.k3;
  return params;
}

void RadtanCamera::validate() const {
  require_positive("RadtanCamera.fx", pinhole_.fx());
  require_positive("RadtanCamera.fy", pinhole_.fy());
  require_finite("RadtanCamera.cx", pinhole_.cx());
  require_finite("RadtanCamera.cy", pinhole_.cy());
  require_finite("RadtanCamera.k1", distortion_.k1);
  require_finite("RadtanCamera.k2", distortion_.k2);
  require_finite("RadtanCamera.p1", distortion_.p1);
  require_finite("RadtanCamera.p2", distortion_.p2);
  require_finite("RadtanCamera.k3", distortion_.k3);
}

bool RadtanCamera::project(const Vector3& p_c,
                           Vector2& uv,
                           RowMajor<2, 3>* J_point,
                           RowMajor<2, kNumParams>* J_params) const {
  if (!(p_c.z() >= kMinDepth)) return false;
  const double inverse_z = 1.0 / p_c.z();
  const Vector2 p = p_c.head<2>() * inverse_z;
  if (!(p.squaredNorm() < max_radius_squared_)) return false;
  RowMajor<2, 2> J_p;
  PolynomialDistortion::ParamJacobian J_k;
  const Vector2 p_distorted = distortion_.distort(p, J_point != nullptr ? &J_p : nullptr,
                                                  J_params != nullptr ? &J_k : nullptr);
  const Eigen::Array2d focal(pinhole_.fx(), pinhole_.fy());
  uv = (focal * p_distorted.array()).matrix() + Vector2(pinhole_.cx(), pinhole_.cy());
  if (J_point != nullptr) {
    // dp/dP = [I | −p] / z.
    J_point->leftCols<2>() = (inverse_z * focal).matrix().asDiagonal() * J_p;
    J_point->col(2) = -J_point->leftCols<2>() * p;
  }
  if (J_params != nullptr) {
    J_params->leftCols<4>() << p_distorted.x(), 0.0, 1.0, 0.0,  //
        0.0, p_distorted.y(), 0.0, 1.0;
    J_params->rightCols<5>() = focal.matrix().asDiagonal() * J_k;
  }
  return uv.allFinite();
}

bool RadtanCamera::unproject(const Vector2& uv,
                             Vector3& bearing,
                             RowMajor<3, 2>* J_uv,
                             RowMajor<3, kNumParams>* J_params) const {
  const double fx = pinhole_.fx();
  const double fy = pinhole_.fy();
  const Vector2 p_distorted((uv.x() - pinhole_.cx()) / fx, (uv.y() - pinhole_.cy()) / fy);
  Vector2 p;
  RowMajor<2, 2> J_p;
  if (!distortion_.undistort(p_distorted, max_radius_squared_, p, J_p)) return false;
  RowMajor<3, 2> J_bearing;
  bearing = bearing_from_normalized(p, 1.0, &J_bearing);
  // p solves distort(p; k) = p_distorted:  dp = J_p⁻¹ (d p_distorted − d(distort)/dk dk).
  const RowMajor<3, 2> J_distorted = J_bearing * J_p.inverse();
  const Vector3 J_u = J_distorted.col(0) / fx;
  const Vector3 J_v = J_distorted.col(1) / fy;
  if (J_uv != nullptr) *J_uv << J_u, J_v;
  if (J_params != nullptr) {
    PolynomialDistortion::ParamJacobian J_k;
    distortion_.distort(p, nullptr, &J_k);
    *J_params << -J_u * p_distorted.x(), -J_v * p_distorted.y(), -J_u, -J_v, -J_distorted * J_k;
  }
  return true;
}

}  // namespace raylign
