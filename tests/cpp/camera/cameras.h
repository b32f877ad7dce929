// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/jet.h>

#include <vector>

#include "raylign/camera/bal.h"
#include "raylign/camera/pinhole.h"
#include "raylign/camera/radtan.h"

/// Real calibrations, and each projection written a second time, plainly, for any scalar.
namespace raylign::test {

inline PinholeCamera kitti_camera() { return {718.856, 718.856, 607.1928, 185.2157}; }

/// TUM RGB-D freiburg1 (Sturm et al. 2012), 640 x 480: a strong and non-monotone k3.
inline RadtanCamera tum_fr1_camera() {
  return {{517.3, 516.5, 318.6, 255.3}, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
}

/// EuRoC MAV cam0 (Burri et al. 2016), 752 x 480: barrel distortion that folds back outside the
/// image.
inline RadtanCamera euroc_camera() {
  return {{458.654, 457.296, 367.215, 248.375},
          {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0}};
}

/// First camera of BAL problem-49-7776 (Ladybug).
inline BalCamera ladybug_camera() {
  return {399.75152639358436, -3.177064385280389e-07, 5.882049053459402e-13};
}

inline BalCamera wide_bal_camera() { return {500.0, -0.12, 0.01}; }

/// The image as a rectangle: [u_min, u_max, v_min, v_max] in px.
struct PixelRange {
  double u_min, u_max, v_min, v_max;
};
inline PixelRange pixel_range(const PinholeCamera& /*camera*/) { return {0.0, 1240.0, 0.0, 375.0}; }
inline PixelRange pixel_range(const RadtanCamera& camera) {
  return {0.0, camera.distortion().k3 != 0.0 ? 639.0 : 751.0, 0.0, 479.0};
}
inline PixelRange pixel_range(const BalCamera& /*camera*/) {
  return {-300.0, 300.0, -250.0, 250.0};
}

inline double viewing_sign(const PinholeCamera& /*camera*/) { return 1.0; }
inline double viewing_sign(const RadtanCamera& /*camera*/) { return 1.0; }
inline double viewing_sign(const BalCamera& /*camera*/) { return -1.0; }

template <typename T>
void plain_project(const PinholeCamera& /*tag*/, const T* k, const T* p, T* uv) {
  uv[0] = k[0] * p[0] / p[2] + k[2];
  uv[1] = k[1] * p[1] / p[2] + k[3];
}

template <typename T>
void plain_project(const BalCamera& /*tag*/, const T* k, const T* p, T* uv) {
  bal_project(k, p, uv);
}

// The formulas of OpenCV's documentation of projectPoints.
template <typename T>
void plain_project(const RadtanCamera& /*tag*/, const T* k, const T* p, T* uv) {
  const T x = p[0] / p[2];
  const T y = p[1] / p[2];
  const T r2 = x * x + y * y;
  const T radial = T(1.0) + k[4] * r2 + k[5] * r2 * r2 + k[8] * r2 * r2 * r2;
  const T xd = x * radial + T(2.0) * k[6] * x * y + k[7] * (r2 + T(2.0) * x * x);
  const T yd = y * radial + k[6] * (r2 + T(2.0) * y * y) + T(2.0) * k[7] * x * y;
  uv[0] = k[0] * xd + k[2];
  uv[1] = k[1] * yd + k[3];
}

/// Value and Jacobians of plain_project by ceres::Jet.
template <typename Camera>
void jet_project(const Camera& camera,
                 const Vector3& p_c,
                 Vector2& uv,
                 RowMajor<2, 3>& J_point,
                 RowMajor<2, Camera::kNumParams>& J_params) {
  constexpr int kDim = 3 + Camera::kNumParams;
  using Jet = ceres::Jet<double, kDim>;
  Jet point[3];
  Jet params[Camera::kNumParams];
  for (int i = 0; i < 3; ++i) point[i] = Jet(p_c[i], i);
  for (int i = 0; i < Camera::kNumParams; ++i) params[i] = Jet(camera.params()[i], 3 + i);
  Jet out[2];
  plain_project(camera, params, point, out);
  for (int i = 0; i < 2; ++i) {
    uv[i] = out[i].a;
    J_point.row(i) = out[i].v.template head<3>().transpose();
    J_params.row(i) = out[i].v.template tail<Camera::kNumParams>().transpose();
  }
}

}  // namespace raylign::test
