// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/clones.h"
#include "raylign/bundle/native/kernel_math.h"
#include "raylign/camera/bearing.h"

/// The cameras as the kernels compute them: one set of overloads for each, chosen by a tag.
///   mask project(kind, camera, P, p)      false where the camera class has no projection
///   void residual(kind, camera, p, uv, r)
///   void jacobian(kind, camera, p, J)     A = J_P R and I, unweighted
/// The formulas are those of camera/{bal,pinhole,radtan}.h, and the tests compare with them.
/// Numbers are double with a CameraPacket, or D4 with four of them (CameraLanes).
namespace raylign::native {

/// Four packets side by side.
struct CameraLanes {
  D4 R[9];
  D4 t[3];
  D4 c[3];
  D4 intrinsics[9];
  D4 max_radius_squared;
  const CameraPacket* packets[4];
};

struct BalKind {
  static constexpr int kNumIntrinsics = 3;
  template <typename T>
  struct Projection {
    T w;  // −1 / P_z
    T x, y, r2, distortion;
  };
};

struct PinholeKind {
  static constexpr int kNumIntrinsics = 4;
  template <typename T>
  struct Projection {
    T w;  // 1 / P_z
    T x, y;
  };
};

struct RadtanKind {
  static constexpr int kNumIntrinsics = 9;
  template <typename T>
  struct Projection {
    T w;  // 1 / P_z
    T x, y, r2, radial;
    T x_distorted, y_distorted;
  };
};

template <typename T>
RAYLIGN_INLINE T magnitude(const T& x) {
  return x < 0.0 ? -x : x;
}

// False when P lies in the camera's plane.
template <typename C, typename T>
RAYLIGN_INLINE auto project(BalKind /*kind*/,
                            const C& camera,
                            const T* P,
                            BalKind::Projection<T>& p) {
  p.w = -1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  p.r2 = p.x * p.x + p.y * p.y;
  p.distortion = 1.0 + p.r2 * (camera.intrinsics[1] + p.r2 * camera.intrinsics[2]);
  return magnitude(P[2]) > kMinDepth * (magnitude(P[0]) + magnitude(P[1]));
}

template <typename C, typename T>
RAYLIGN_INLINE void residual(
    BalKind /*kind*/, const C& camera, const BalKind::Projection<T>& p, const T* uv, T* r) {
  const T scale = camera.intrinsics[0] * p.distortion;
  r[0] = scale * p.x - uv[0];
  r[1] = scale * p.y - uv[1];
}

template <typename C, typename T>
RAYLIGN_INLINE void jacobian(BalKind /*kind*/,
                             const C& camera,
                             const BalKind::Projection<T>& p,
                             JacobianOf<T>& J) {
  const T f = camera.intrinsics[0];
  const T a = f * p.distortion * p.w;
  const T g = 2.0 * f * (camera.intrinsics[1] + 2.0 * camera.intrinsics[2] * p.r2) * p.w;
  const T radial = a + g * p.r2;
  const T xx = a + g * p.x * p.x;
  const T xy = g * p.x * p.y;
  const T yy = a + g * p.y * p.y;
  const T* R = camera.R;
  for (int k = 0; k < 3; ++k) {
    J.A[k] = xx * R[k] + xy * R[3 + k] + radial * p.x * R[6 + k];
    J.A[3 + k] = xy * R[k] + yy * R[3 + k] + radial * p.y * R[6 + k];
  }
  const T f_r2 = f * p.r2;
  const T f_r4 = f_r2 * p.r2;
  const T I[6] = {p.distortion * p.x, f_r2 * p.x, f_r4 * p.x,
                  p.distortion * p.y, f_r2 * p.y, f_r4 * p.y};
  for (int k = 0; k < 6; ++k) J.I[k] = I[k];
}

// A of a camera along +z: J_P = w D [I | −p], D = ∂(u, v)/∂p by rows.
template <typename C, typename T>
RAYLIGN_INLINE void rotate_jacobian(
    const C& camera, const T* D, const T& w, const T& x, const T& y, T* A) {
  const T* R = camera.R;
  for (int row = 0; row < 2; ++row) {
    const T a = w * D[2 * row];
    const T b = w * D[2 * row + 1];
    const T c = -(a * x + b * y);
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
RAYLIGN_INLINE void pick_columns(const CameraLanes& cameras, const D4* all, int count, D4* I) {
  for (int lane = 0; lane < 4; ++lane) {
    for (int k = 0; k < 3; ++k) {
      const int column = cameras.packets[lane]->columns[k];
      I[k][lane] = column < 0 ? 0.0 : all[column][lane];
      I[3 + k][lane] = column < 0 ? 0.0 : all[count + column][lane];
    }
  }
}

template <typename C, typename T>
RAYLIGN_INLINE auto project(PinholeKind /*kind*/,
                            const C& /*camera*/,
                            const T* P,
                            PinholeKind::Projection<T>& p) {
  p.w = 1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  return P[2] >= kMinDepth;
}

template <typename C, typename T>
RAYLIGN_INLINE void residual(
    PinholeKind /*kind*/, const C& camera, const PinholeKind::Projection<T>& p, const T* uv, T* r) {
  const T* k = camera.intrinsics;
  r[0] = k[0] * p.x + k[2] - uv[0];
  r[1] = k[1] * p.y + k[3] - uv[1];
}

template <typename C, typename T>
RAYLIGN_INLINE void jacobian(PinholeKind /*kind*/,
                             const C& camera,
                             const PinholeKind::Projection<T>& p,
                             JacobianOf<T>& J) {
  const T zero = {};
  const T one = zero + 1.0;
  const T D[4] = {camera.intrinsics[0], zero, zero, camera.intrinsics[1]};
  rotate_jacobian(camera, D, p.w, p.x, p.y, J.A);
  const T I[8] = {p.x, zero, one, zero, zero, p.y, zero, one};
  pick_columns(camera, I, 4, J.I);
}

template <typename C, typename T>
RAYLIGN_INLINE auto project(RadtanKind /*kind*/,
                            const C& camera,
                            const T* P,
                            RadtanKind::Projection<T>& p) {
  p.w = 1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  p.r2 = p.x * p.x + p.y * p.y;
  const T* k = camera.intrinsics;
  p.radial = 1.0 + p.r2 * (k[4] + p.r2 * (k[5] + p.r2 * k[8]));
  p.x_distorted = p.radial * p.x + 2.0 * k[6] * p.x * p.y + k[7] * (p.r2 + 2.0 * p.x * p.x);
  p.y_distorted = p.radial * p.y + k[6] * (p.r2 + 2.0 * p.y * p.y) + 2.0 * k[7] * p.x * p.y;
  return (P[2] >= kMinDepth) & (p.r2 < camera.max_radius_squared);
}

template <typename C, typename T>
RAYLIGN_INLINE void residual(
    RadtanKind /*kind*/, const C& camera, const RadtanKind::Projection<T>& p, const T* uv, T* r) {
  const T* k = camera.intrinsics;
  r[0] = k[0] * p.x_distorted + k[2] - uv[0];
  r[1] = k[1] * p.y_distorted + k[3] - uv[1];
}

template <typename C, typename T>
RAYLIGN_INLINE void jacobian(RadtanKind /*kind*/,
                             const C& camera,
                             const RadtanKind::Projection<T>& p,
                             JacobianOf<T>& J) {
  const T* k = camera.intrinsics;
  const T fx = k[0];
  const T fy = k[1];
  const T slope = 2.0 * (k[4] + p.r2 * (2.0 * k[5] + p.r2 * 3.0 * k[8]));  // 2 d(radial)/d(r²)
  const T mixed = slope * p.x * p.y + 2.0 * (k[6] * p.x + k[7] * p.y);
  const T xx = p.radial + slope * p.x * p.x + 2.0 * k[6] * p.y + 6.0 * k[7] * p.x;
  const T yy = p.radial + slope * p.y * p.y + 6.0 * k[6] * p.y + 2.0 * k[7] * p.x;
  const T D[4] = {fx * xx, fx * mixed, fy * mixed, fy * yy};
  rotate_jacobian(camera, D, p.w, p.x, p.y, J.A);
  const T r4 = p.r2 * p.r2;
  const T zero = {};
  const T one = zero + 1.0;
  const T I[18] = {p.x_distorted,
                   zero,
                   one,
                   zero,
                   fx * p.x * p.r2,
                   fx * p.x * r4,
                   fx * 2.0 * p.x * p.y,
                   fx * (p.r2 + 2.0 * p.x * p.x),
                   fx * p.x * r4 * p.r2,
                   zero,
                   p.y_distorted,
                   zero,
                   one,
                   fy * p.y * p.r2,
                   fy * p.y * r4,
                   fy * (p.r2 + 2.0 * p.y * p.y),
                   fy * 2.0 * p.x * p.y,
                   fy * p.y * r4 * p.r2};
  pick_columns(camera, I, 9, J.I);
}

}  // namespace raylign::native
