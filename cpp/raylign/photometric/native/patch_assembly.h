// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/double_lanes.h"
#include "raylign/photometric/native/patch_projection.h"
#include "raylign/photometric/native/patch_tensor.h"

/// From the tensor of an edge to the normal equations of its image, point and host. Included by
/// patch_kernels.cpp alone.
namespace raylign::native {

// How (u, v) moves with the image (F, C columns) and with the point (P).
template <int C>
struct Motion {
  double F[2][C];
  double P[2][3];
};

template <int C>
RAYLIGN_INLINE void image_motion(const ImagePacket& image,
                                 const Projection& p,
                                 double w,
                                 Motion<C>& out) {
  const double X = image.fx * p.inverse_z;
  const double Y = image.fy * p.inverse_z;
  const double x = p.x;
  const double y = p.y;
  const double pose[2][6] = {
      {w * X, 0.0, -w * X * x, -image.fx * x * y, image.fx * (1.0 + x * x), -image.fx * y},
      {0.0, w * Y, -w * Y * y, -image.fy * (1.0 + y * y), image.fy * x * y, image.fy * x}};
  for (int row = 0; row < 2; ++row) {
    for (int k = 0; k < 6; ++k) out.F[row][k] = pose[row][k];
    out.F[row][6] = out.F[row][7] = 0.0;
  }
  if (C > 8) {
    const double intrinsics[2][4] = {{x, 0.0, 1.0, 0.0}, {0.0, y, 0.0, 1.0}};
    for (int row = 0; row < 2; ++row) {
      for (int k = 0; k < 4; ++k) out.F[row][C - 4 + k] = intrinsics[row][k];
    }
  }
  for (int k = 0; k < 3; ++k) {
    out.P[0][k] = X * (image.R[k] - x * image.R[6 + k]);
    out.P[1][k] = Y * (image.R[3 + k] - y * image.R[6 + k]);
  }
}

// How (u, v) moves with the host's pose, and with ρ: P becomes ∂(u, v)/∂ρ in its first column.
template <int C>
RAYLIGN_INLINE void host_motion(const ImagePacket& host,
                                const ImagePacket& image,
                                const HomogeneousPoint& point,
                                const Projection& p,
                                Motion<C>& motion,
                                double (*F_h)[C]) {
  const double f[2] = {image.fx * p.inverse_z, image.fy * p.inverse_z};
  const double xy[2] = {p.x, p.y};
  for (int row = 0; row < 2; ++row) {
    double Q[3];  // ∂(u, v)/∂(point in the host's frame)
    for (int k = 0; k < 3; ++k) {
      Q[k] = motion.P[row][0] * host.R[3 * k] + motion.P[row][1] * host.R[3 * k + 1] +
             motion.P[row][2] * host.R[3 * k + 2];
    }
    // −Q [w I | −[ray]×]
    for (int k = 0; k < 3; ++k) F_h[row][k] = -point.w * Q[k];
    F_h[row][3] = -(point.ray[1] * Q[2] - point.ray[2] * Q[1]);
    F_h[row][4] = -(point.ray[2] * Q[0] - point.ray[0] * Q[2]);
    F_h[row][5] = -(point.ray[0] * Q[1] - point.ray[1] * Q[0]);
    if (C > 8) {  // the ray is K_h⁻¹ u_h
      F_h[row][C - 4] = -Q[0] * point.ray[0] / host.fx;
      F_h[row][C - 3] = -Q[1] * point.ray[1] / host.fy;
      F_h[row][C - 2] = -Q[0] / host.fx;
      F_h[row][C - 1] = -Q[1] / host.fy;
    }
    motion.P[row][0] = f[row] * (image.t[row] - xy[row] * image.t[2]) -
                       (Q[0] * host.t[0] + Q[1] * host.t[1] + Q[2] * host.t[2]);
    motion.P[row][1] = motion.P[row][2] = 0.0;
  }
}

// The four rows of an image's F times T: rows 2 and 3 of F hold one number each, at a and b.
template <int C>
RAYLIGN_INLINE void multiply_tensor(const EdgeTensor& e,
                                    const double (*F)[C],
                                    double host_gain,
                                    double (*TF)[C]) {
  for (int k = 0; k < C; k += 4) {
    D4 f0, f1;
    load(F[0] + k, f0);
    load(F[1] + k, f1);
    for (int row = 0; row < 4; ++row) store(e.T[row][0] * f0 + e.T[row][1] * f1, TF[row] + k);
  }
  for (int row = 0; row < 4; ++row) {
    TF[row][6] = e.T[row][2];
    TF[row][7] = e.T[row][3] * host_gain;
  }
}

template <int C>
RAYLIGN_INLINE void add_image(const EdgeTensor& e,
                              const Motion<C>& motion,
                              const double (*TF)[C],
                              double host_gain,
                              double* H,
                              double* g) {
  const double v[4] = {e.v[0], e.v[1], e.v[2], host_gain * e.v[3]};
  for (int k = 0; k < C; k += 4) {
    D4 t[4], f0, f1, sum;
    for (int row = 0; row < 4; ++row) load(TF[row] + k, t[row]);
    for (int i = 0; i < C; ++i) {
      load(H + i * C + k, sum);
      if (i == 6) {
        sum += t[2];
      } else if (i == 7) {
        sum += host_gain * t[3];
      } else {
        sum += motion.F[0][i] * t[0] + motion.F[1][i] * t[1];
      }
      store(sum, H + i * C + k);
    }
    load(motion.F[0] + k, f0);
    load(motion.F[1] + k, f1);
    load(g + k, sum);
    store(sum - (v[0] * f0 + v[1] * f1), g + k);
  }
  g[6] -= v[2];
  g[7] -= v[3];
}

template <int C>
RAYLIGN_INLINE void add_point(const EdgeTensor& e,
                              const Motion<C>& motion,
                              const double (*TF)[C],
                              int point_size,
                              double* W,
                              PointBlock& block) {
  const double (*P)[3] = motion.P;
  for (int k = 0; k < C; k += 4) {
    D4 t0, t1, sum;
    load(TF[0] + k, t0);
    load(TF[1] + k, t1);
    for (int d = 0; d < point_size; ++d) {
      load(W + d * C + k, sum);
      store(sum + (P[0][d] * t0 + P[1][d] * t1), W + d * C + k);
    }
  }
  double GP[2][3];
  for (int d = 0; d < 3; ++d) {
    GP[0][d] = e.T[0][0] * P[0][d] + e.T[0][1] * P[1][d];
    GP[1][d] = e.T[1][0] * P[0][d] + e.T[1][1] * P[1][d];
    block.g[d] -= P[0][d] * e.v[0] + P[1][d] * e.v[1];
  }
  int n = 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = i; k < 3; ++k) block.H[n++] += P[0][i] * GP[0][k] + P[1][i] * GP[1][k];
  }
}

// What the host's pose (inverse depth) and brightness add: F_h has four full rows.
template <int C>
RAYLIGN_INLINE void add_host(const PatchArrays& arrays,
                             const NormalArrays& out,
                             const EdgeTensor& e,
                             const Motion<C>& motion,
                             const double (*F_h)[C],
                             double host_gain,
                             std::int32_t image,
                             std::int32_t host,
                             double* W_h) {
  double TF[4][C];
  for (int row = 0; row < 4; ++row) {
    for (int k = 0; k < C; ++k) {
      TF[row][k] = e.T[row][0] * F_h[0][k] + e.T[row][1] * F_h[1][k] + e.T[row][2] * F_h[2][k] +
                   e.T[row][3] * F_h[3][k];
    }
  }
  const int rows_of_point = arrays.inverse_depth ? 1 : 3;
  for (int d = 0; d < rows_of_point; ++d) {
    for (int k = 0; k < C; ++k) {
      W_h[d * C + k] += motion.P[0][d] * TF[0][k] + motion.P[1][d] * TF[1][k];
    }
  }
  double* H = out.diagonal + static_cast<std::int64_t>(host) * C * C;
  double* g = out.gradient + static_cast<std::int64_t>(host) * C;
  for (int i = 0; i < C; ++i) {
    for (int k = 0; k < C; ++k) {
      H[i * C + k] +=
          F_h[0][i] * TF[0][k] + F_h[1][i] * TF[1][k] + F_h[2][i] * TF[2][k] + F_h[3][i] * TF[3][k];
    }
    g[i] -= F_h[0][i] * e.v[0] + F_h[1][i] * e.v[1] + F_h[2][i] * e.v[2] + F_h[3][i] * e.v[3];
  }
  double X[C][C];  // image rows, host columns
  for (int i = 0; i < C; ++i) {
    const double f0 = motion.F[0][i];
    const double f1 = motion.F[1][i];
    for (int k = 0; k < C; ++k) X[i][k] = f0 * TF[0][k] + f1 * TF[1][k];
  }
  for (int k = 0; k < C; ++k) {
    X[6][k] = TF[2][k];
    X[7][k] = host_gain * TF[3][k];
  }
  if (image == host) {
    for (int i = 0; i < C; ++i) {
      for (int k = 0; k < C; ++k) H[i * C + k] += X[i][k] + X[k][i];
    }
    return;
  }
  const bool is_upper = image < host;
  const std::int32_t low = is_upper ? image : host;
  const std::int32_t high = is_upper ? host : image;
  double* block = out.cross + (out.block_starts[low] + high - low) * C * C;
  for (int i = 0; i < C; ++i) {
    for (int k = 0; k < C; ++k) block[i * C + k] += is_upper ? X[i][k] : X[k][i];
  }
}

template <int C>
RAYLIGN_INLINE void add_edge(const PatchArrays& arrays,
                             const PatchStateArrays& state,
                             const NormalArrays& out,
                             std::int64_t p,
                             const KernelEdge& edge,
                             const HomogeneousPoint& point,
                             const Projection& projection,
                             const Brightness& brightness,
                             const EdgeTensor& tensor) {
  const ImagePacket& image = state.images[edge.image];
  Motion<C> motion;
  image_motion(image, projection, point.w, motion);
  const std::int32_t host = arrays.hosts[p];
  double F_h[4][C] = {};
  if (arrays.inverse_depth) {
    host_motion(state.images[host], image, point, projection, motion, F_h);
  }
  double TF[4][C];
  multiply_tensor<C>(tensor, motion.F, brightness.host_gain, TF);
  add_image<C>(tensor, motion, TF, brightness.host_gain,
               out.diagonal + static_cast<std::int64_t>(edge.image) * C * C,
               out.gradient + static_cast<std::int64_t>(edge.image) * C);
  double* W = out.W + arrays.slot_starts[p] * 3 * C;
  const int point_size = arrays.inverse_depth ? 1 : 3;
  add_point<C>(tensor, motion, TF, point_size, W + edge.slot * 3 * C, out.points[p]);
  if (host < 0) return;
  F_h[2][6] = -1.0;
  F_h[3][6] = -brightness.offset;
  F_h[3][7] = -brightness.host_gain;
  add_host<C>(arrays, out, tensor, motion, F_h, brightness.host_gain, edge.image, host,
              W + arrays.host_slots[p] * 3 * C);
}

}  // namespace raylign::native
