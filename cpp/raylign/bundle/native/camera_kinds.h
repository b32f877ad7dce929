// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/kernel_math.h"
#include "raylign/camera/bearing.h"

/// The cameras as the kernels compute them: one set of overloads for each, chosen by a tag.
///   bool project(kind, camera, P, p)      false where the camera class has no projection
///   void residual(kind, camera, p, uv, r)
///   void jacobian(kind, camera, p, J)     A = J_P R and I, unweighted
/// The formulas are those of camera/{bal,pinhole,radtan}.h, and the tests compare with them.
namespace raylign::native {

struct BalKind {
  struct Projection {
    double w;  // −1 / P_z
    double x, y, r2, distortion;
  };
};

struct PinholeKind {
  struct Projection {
    double w;  // 1 / P_z
    double x, y;
  };
};

struct RadtanKind {
  struct Projection {
    double w;  // 1 / P_z
    double x, y, r2, radial;
    double x_distorted, y_distorted;
  };
};

// False when P lies in the camera's plane.
RAYLIGN_INLINE bool project(BalKind /*kind*/,
                            const CameraPacket& camera,
                            const double* P,
                            BalKind::Projection& p) {
  if (!(std::abs(P[2]) > kMinDepth * (std::abs(P[0]) + std::abs(P[1])))) return false;
  p.w = -1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  p.r2 = p.x * p.x + p.y * p.y;
  p.distortion = 1.0 + p.r2 * (camera.intrinsics[1] + p.r2 * camera.intrinsics[2]);
  return true;
}

RAYLIGN_INLINE void residual(BalKind /*kind*/,
                             const CameraPacket& camera,
                             const BalKind::Projection& p,
                             const double* uv,
                             double* r) {
  const double scale = camera.intrinsics[0] * p.distortion;
  r[0] = scale * p.x - uv[0];
  r[1] = scale * p.y - uv[1];
}

RAYLIGN_INLINE void jacobian(BalKind /*kind*/,
                             const CameraPacket& camera,
                             const BalKind::Projection& p,
                             ObservationJacobian& J) {
  const double f = camera.intrinsics[0];
  const double a = f * p.distortion * p.w;
  const double g = 2.0 * f * (camera.intrinsics[1] + 2.0 * camera.intrinsics[2] * p.r2) * p.w;
  const double radial = a + g * p.r2;
  const double xx = a + g * p.x * p.x;
  const double xy = g * p.x * p.y;
  const double yy = a + g * p.y * p.y;
  const double* R = camera.R;
  for (int k = 0; k < 3; ++k) {
    J.A[k] = xx * R[k] + xy * R[3 + k] + radial * p.x * R[6 + k];
    J.A[3 + k] = xy * R[k] + yy * R[3 + k] + radial * p.y * R[6 + k];
  }
  const double f_r2 = f * p.r2;
  const double f_r4 = f_r2 * p.r2;
  const double I[6] = {p.distortion * p.x, f_r2 * p.x, f_r4 * p.x,
                       p.distortion * p.y, f_r2 * p.y, f_r4 * p.y};
  for (int k = 0; k < 6; ++k) J.I[k] = I[k];
}

// A of a camera along +z: J_P = w D [I | −p], D = ∂(u, v)/∂p by rows.
RAYLIGN_INLINE void rotate_jacobian(
    const CameraPacket& camera, const double* D, double w, double x, double y, double* A) {
  const double* R = camera.R;
  for (int row = 0; row < 2; ++row) {
    const double a = w * D[2 * row];
    const double b = w * D[2 * row + 1];
    const double c = -(a * x + b * y);
    for (int k = 0; k < 3; ++k) A[3 * row + k] = a * R[k] + b * R[3 + k] + c * R[6 + k];
  }
}

// The columns of the parameters that may move, out of all `count`; zero where there is none.
RAYLIGN_INLINE void pick_columns(const CameraPacket& camera,
                                 const double* all,
                                 int count,
                                 double* I) {
  for (int k = 0; k < 3; ++k) {
    const int column = camera.columns[k];
    I[k] = column < 0 ? 0.0 : all[column];
    I[3 + k] = column < 0 ? 0.0 : all[count + column];
  }
}

RAYLIGN_INLINE bool project(PinholeKind /*kind*/,
                            const CameraPacket& /*camera*/,
                            const double* P,
                            PinholeKind::Projection& p) {
  if (!(P[2] >= kMinDepth)) return false;
  p.w = 1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  return true;
}

RAYLIGN_INLINE void residual(PinholeKind /*kind*/,
                             const CameraPacket& camera,
                             const PinholeKind::Projection& p,
                             const double* uv,
                             double* r) {
  const double* k = camera.intrinsics;
  r[0] = k[0] * p.x + k[2] - uv[0];
  r[1] = k[1] * p.y + k[3] - uv[1];
}

RAYLIGN_INLINE void jacobian(PinholeKind /*kind*/,
                             const CameraPacket& camera,
                             const PinholeKind::Projection& p,
                             ObservationJacobian& J) {
  const double D[4] = {camera.intrinsics[0], 0.0, 0.0, camera.intrinsics[1]};
  rotate_jacobian(camera, D, p.w, p.x, p.y, J.A);
  const double I[8] = {p.x, 0.0, 1.0, 0.0, 0.0, p.y, 0.0, 1.0};
  pick_columns(camera, I, 4, J.I);
}

RAYLIGN_INLINE bool project(RadtanKind /*kind*/,
                            const CameraPacket& camera,
                            const double* P,
                            RadtanKind::Projection& p) {
  if (!(P[2] >= kMinDepth)) return false;
  p.w = 1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  p.r2 = p.x * p.x + p.y * p.y;
  if (!(p.r2 < camera.max_radius_squared)) return false;
  const double* k = camera.intrinsics;
  p.radial = 1.0 + p.r2 * (k[4] + p.r2 * (k[5] + p.r2 * k[8]));
  p.x_distorted = p.radial * p.x + 2.0 * k[6] * p.x * p.y + k[7] * (p.r2 + 2.0 * p.x * p.x);
  p.y_distorted = p.radial * p.y + k[6] * (p.r2 + 2.0 * p.y * p.y) + 2.0 * k[7] * p.x * p.y;
  return true;
}

RAYLIGN_INLINE void residual(RadtanKind /*kind*/,
                             const CameraPacket& camera,
                             const RadtanKind::Projection& p,
                             const double* uv,
                             double* r) {
  const double* k = camera.intrinsics;
  r[0] = k[0] * p.x_distorted + k[2] - uv[0];
  r[1] = k[1] * p.y_distorted + k[3] - uv[1];
}

RAYLIGN_INLINE void jacobian(RadtanKind /*kind*/,
                             const CameraPacket& camera,
                             const RadtanKind::Projection& p,
                             ObservationJacobian& J) {
  const double* k = camera.intrinsics;
  const double fx = k[0];
  const double fy = k[1];
  const double slope = 2.0 * (k[4] + p.r2 * (2.0 * k[5] + p.r2 * 3.0 * k[8]));  // 2 d(radial)/d(r²)
  const double mixed = slope * p.x * p.y + 2.0 * (k[6] * p.x + k[7] * p.y);
  const double xx = p.radial + slope * p.x * p.x + 2.0 * k[6] * p.y + 6.0 * k[7] * p.x;
  const double yy = p.radial + slope * p.y * p.y + 6.0 * k[6] * p.y + 2.0 * k[7] * p.x;
  const double D[4] = {fx * xx, fx * mixed, fy * mixed, fy * yy};
  rotate_jacobian(camera, D, p.w, p.x, p.y, J.A);
  const double r4 = p.r2 * p.r2;
  const double I[18] = {p.x_distorted,
                        0.0,
                        1.0,
                        0.0,
                        fx * p.x * p.r2,
                        fx * p.x * r4,
                        fx * 2.0 * p.x * p.y,
                        fx * (p.r2 + 2.0 * p.x * p.x),
                        fx * p.x * r4 * p.r2,
                        0.0,
                        p.y_distorted,
                        0.0,
                        1.0,
                        fy * p.y * p.r2,
                        fy * p.y * r4,
                        fy * (p.r2 + 2.0 * p.y * p.y),
                        fy * 2.0 * p.x * p.y,
                        fy * p.y * r4 * p.r2};
  pick_columns(camera, I, 9, J.I);
}

}  // namespace raylign::native
