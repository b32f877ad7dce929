// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/kernels.h"

#include <cmath>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/kernel_math.h"
#include "raylign/camera/bearing.h"

namespace raylign::native {
namespace {

// P = R X + t.
RAYLIGN_INLINE void transform(const CameraPacket& camera, const double* X, double* P) {
  for (int k = 0; k < 3; ++k) P[k] = dot3(camera.R + 3 * k, X) + camera.t[k];
}

struct Projection {
  double w;  // −1 / P_z
  double x, y, r2, distortion;
};

// False when P lies in the camera's plane. The formulas of BalCamera::project.
RAYLIGN_INLINE bool project(const CameraPacket& camera, const double* P, Projection& p) {
  if (!(std::abs(P[2]) > kMinDepth * (std::abs(P[0]) + std::abs(P[1])))) return false;
  p.w = -1.0 / P[2];
  p.x = P[0] * p.w;
  p.y = P[1] * p.w;
  p.r2 = p.x * p.x + p.y * p.y;
  p.distortion = 1.0 + p.r2 * (camera.intrinsics[1] + p.r2 * camera.intrinsics[2]);
  return true;
}

RAYLIGN_INLINE void residual(const CameraPacket& camera,
                             const Projection& p,
                             const double* uv,
                             double* r) {
  const double scale = camera.intrinsics[0] * p.distortion;
  r[0] = scale * p.x - uv[0];
  r[1] = scale * p.y - uv[1];
}

// A = J_P R and I, unweighted.
RAYLIGN_INLINE void jacobian(const CameraPacket& camera,
                             const Projection& p,
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

// Multiplies J and r by √ρ′ and returns ρ.
RAYLIGN_INLINE double apply_loss(const Loss& loss, double s, ObservationJacobian& J, double* r) {
  const LossValue value = loss.evaluate(s);
  const double weight = std::sqrt(value.d_rho);
  for (int k = 0; k < 6; ++k) J.A[k] *= weight;
  for (int k = 0; k < 6; ++k) J.I[k] *= weight;
  r[0] *= weight;
  r[1] *= weight;
  return value.rho;
}

RAYLIGN_INLINE void add_landmark(const double* A, const double* r, LandmarkBlock& block) {
  const double* b = A + 3;
  block.H[0] += A[0] * A[0] + b[0] * b[0];
  block.H[1] += A[0] * A[1] + b[0] * b[1];
  block.H[2] += A[0] * A[2] + b[0] * b[2];
  block.H[3] += A[1] * A[1] + b[1] * b[1];
  block.H[4] += A[1] * A[2] + b[1] * b[2];
  block.H[5] += A[2] * A[2] + b[2] * b[2];
  for (int k = 0; k < 3; ++k) block.g[k] += A[k] * r[0] + b[k] * r[1];
}

RAYLIGN_INLINE void add_camera(const double* F, const double* r, CameraSums& sums) {
  const Lanes* f0 = lanes(F);
  const Lanes* f1 = lanes(F + kRow);
  for (int row = 0; row < 9; ++row) {
    Lanes* U = lanes(sums.U.values + row * kRow);
    for (int v = 0; v < kLanes; ++v) U[v] += F[row] * f0[v] + F[kRow + row] * f1[v];
  }
  Lanes* g = lanes(sums.g);
  for (int v = 0; v < kLanes; ++v) g[v] += r[0] * f0[v] + r[1] * f1[v];
}

}  // namespace

RAYLIGN_CLONES double linearize(const Observations& observations,
                                std::int64_t begin,
                                std::int64_t end,
                                const CameraPacket* packets,
                                const double* X,
                                const Loss* loss,
                                ObservationJacobian* J,
                                LandmarkBlock* blocks,
                                CameraSums* cameras) {
  double cost = 0.0;
  for (std::int64_t j = begin; j < end; ++j) {
    LandmarkBlock block = {};
    for (std::int64_t q = observations.starts[j]; q < observations.starts[j + 1]; ++q) {
      const std::int32_t i = observations.camera[q];
      double P[3];
      transform(packets[i], X + 3 * j, P);
      Projection p;
      if (!project(packets[i], P, p)) return NAN;
      double r[2];
      residual(packets[i], p, observations.uv + 2 * q, r);
      ObservationJacobian J_q;
      jacobian(packets[i], p, J_q);
      const double s = r[0] * r[0] + r[1] * r[1];
      cost += loss == nullptr ? s : apply_loss(*loss, s, J_q, r);
      J[q] = J_q;
      alignas(32) double F[2 * kRow];
      camera_rows(J_q, X + 3 * j, packets[i].c, F);
      add_landmark(J_q.A, r, block);
      add_camera(F, r, cameras[i]);
    }
    blocks[j] = block;
  }
  return 0.5 * cost;
}

RAYLIGN_CLONES TrialSums try_landmarks(const Observations& observations,
                                       std::int64_t begin,
                                       std::int64_t end,
                                       const CameraPacket* packets,
                                       const CameraPacket* trial_packets,
                                       const double* X,
                                       const Loss* loss,
                                       const ObservationJacobian* J,
                                       const LandmarkBlock* blocks,
                                       const LandmarkFactor* factors,
                                       const double* delta,
                                       double* X_trial,
                                       double* scratch) {
  TrialSums sums;
  for (std::int64_t j = begin; j < end; ++j) {
    const std::int64_t first = observations.starts[j];
    const std::int64_t last = observations.starts[j + 1];
    const double* X_j = X + 3 * j;
    double y[3] = {blocks[j].g[0], blocks[j].g[1], blocks[j].g[2]};  // g + Σ Aᵀ F δ
    for (std::int64_t q = first; q < last; ++q) {
      const std::int32_t i = observations.camera[q];
      const double* d = delta + std::int64_t{i} * kRow;
      const double* c = packets[i].c;
      const double a[3] = {X_j[0] - c[0], X_j[1] - c[1], X_j[2] - c[2]};
      double moved[3];  // Fδ = A (ω × a − δc) + I δ(f, k1, k2)
      cross(d, a, moved);
      for (int k = 0; k < 3; ++k) moved[k] -= d[3 + k];
      double* v = scratch + 2 * (q - first);
      v[0] = dot3(J[q].A, moved) + dot3(J[q].I, d + 6);
      v[1] = dot3(J[q].A + 3, moved) + dot3(J[q].I + 3, d + 6);
      for (int k = 0; k < 3; ++k) y[k] += J[q].A[k] * v[0] + J[q].A[3 + k] * v[1];
    }
    const double* W = factors[j].W;
    double z[3];
    double step[3];
    multiply_transposed(W, y, z);
    multiply(W, z, step);
    const bool moves = W[0] != 0.0 || W[3] != 0.0 || W[5] != 0.0;
    for (int k = 0; k < 3; ++k) {
      step[k] = -step[k];
      X_trial[3 * j + k] = X_j[k] + step[k];
      sums.squared_step += step[k] * step[k];
      sums.squared_state += moves ? X_j[k] * X_j[k] : 0.0;
    }
    sums.model_decrease -= dot3(blocks[j].g, step);
    for (std::int64_t q = first; q < last; ++q) {
      const double* v = scratch + 2 * (q - first);
      const double u0 = v[0] + dot3(J[q].A, step);
      const double u1 = v[1] + dot3(J[q].A + 3, step);
      sums.model_decrease -= 0.5 * (u0 * u0 + u1 * u1);
      const CameraPacket& camera = trial_packets[observations.camera[q]];
      double P[3];
      transform(camera, X_trial + 3 * j, P);
      Projection p;
      double r[2] = {NAN, NAN};
      if (project(camera, P, p)) residual(camera, p, observations.uv + 2 * q, r);
      const double s = r[0] * r[0] + r[1] * r[1];
      sums.cost += 0.5 * (loss == nullptr ? s : loss->evaluate(s).rho);
    }
  }
  return sums;
}

}  // namespace raylign::native
