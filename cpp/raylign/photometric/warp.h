// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

namespace raylign::photometric {

/// How the plane through a point maps the surroundings of its pixel in the host to those in an
/// image: the derivative of the homography of that plane at the host's pixel.
struct PlaneWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();  ///< ∂u_j / ∂u_h, px of level 0
  double cos_view = 1.0;  ///< cosine of the angle between normal and viewing ray in image j
  bool is_valid = false;  ///< in front of both cameras, both on the same side of the plane

  /// Footprint √|det A|: how much larger the patch is in the image than in its host.
  double scale() const;
};

/// A[:, i] = P_j R_jh z_h (e_i / f_i − r_h n_i / (f_i n · r_h)), P_j = ∂u_j / ∂q at q = z_h R_jh
/// r_h + t_jh. The normal e_z is that of a surface of constant depth.
/// @param ray     r_h = K_h⁻¹ (u, v, 1)
/// @param depth   z_h
/// @param normal  host frame, any length and sign
/// @param K_h, K_j  fx, fy, cx, cy
PlaneWarp plane_warp(const Matrix3& R_jh,
                     const Vector3& t_jh,
                     const Vector3& ray,
                     double depth,
                     const Vector3& normal,
                     const Vector4& K_h,
                     const Vector4& K_j);

}  // namespace raylign::photometric
