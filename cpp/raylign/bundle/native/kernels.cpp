// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/kernels.h"

#include <cmath>
#include <type_traits>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/kernel_math.h"

// GCC 12 takes filling a vector lane by lane, where the machine has none so wide, for a read.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
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

// F = [a × A | −A | I] and r.
RAYLIGN_INLINE void write_rows(const ObservationJacobian& J,
                               const double* X,
                               const double* c,
                               const double* r,
                               CameraRows& rows) {
  const double a[3] = {X[0] - c[0], X[1] - c[1], X[2] - c[2]};
  for (int row = 0; row < 2; ++row) {
    double* f = rows.F[row];
    const double* A = J.A + 3 * row;
    cross(a, A, f);
    for (int k = 0; k < 3; ++k) f[3 + k] = -A[k];
    f[6] = J.I[3 * row];
    f[7] = J.I[3 * row + 1];
    rows.tail[row] = J.I[3 * row + 2];
    rows.r[row] = r[row];
  }
}

// One landmark: J, H, g, and F for the cameras. Adds to the cost; false when there is none.
RAYLIGN_INLINE bool linearize_landmark(const Observations& observations,
                                       std::int64_t j,
                                       const CameraPacket* packets,
                                       const double* X,
                                       const Loss* loss,
                                       ObservationJacobian* J,
                                       LandmarkBlock* blocks,
                                       CameraRows* rows,
                                       double& cost) {
  LandmarkBlock block = {};
  for (std::int64_t q = observations.starts[j]; q < observations.starts[j + 1]; ++q) {
    const CameraPacket& camera = packets[observations.camera[q]];
    double P[3];
    transform(camera, X + 3 * j, P);
    Projection p;
    if (!project(camera, P, p)) return false;
    double r[2];
    residual(camera, p, observations.uv + 2 * q, r);
    ObservationJacobian J_q;
    jacobian(camera, p, J_q);
    const double s = r[0] * r[0] + r[1] * r[1];
    cost += loss == nullptr ? s : apply_loss(*loss, s, J_q, r);
    J[q] = J_q;
    add_landmark(J_q.A, r, block);
    write_rows(J_q, X + 3 * j, camera.c, r, *rows++);
  }
  blocks[j] = block;
  return true;
}

// Rows [kFirst, kLast) < 8 of U += Σ FᵀF, columns 0 … 7, and with kEdge the ninth row, which is
// the ninth column too, and g += Σ Fᵀr.
template <typename Width, int kFirst, int kLast, bool kEdge>
RAYLIGN_INLINE void add_sweep(const CameraRows* rows,
                              const std::int32_t* place,
                              const std::int32_t* end,
                              CameraSums& sums) {
  using Vector = typename Width::Vector;
  constexpr int kWidth = sizeof(Vector) / sizeof(double);
  constexpr int kVectors = 8 / kWidth;
  constexpr int kRows = kLast - kFirst;
  double* U = sums.U.values;
  Vector sum[kRows + 1][kVectors];
  Vector ninth[kVectors];
  Vector g[kVectors];
  for (int v = 0; v < kVectors; ++v) {
    for (int r = 0; r < kRows; ++r) sum[r][v] = at<Width>(U + (kFirst + r) * kRow + v * kWidth);
    ninth[v] = at<Width>(U + 8 * kRow + v * kWidth);
    g[v] = at<Width>(sums.g + v * kWidth);
  }
  double corner = U[8 * kRow + 8];
  double g_corner = sums.g[8];
  for (; place != end; ++place) {
    const CameraRows& row = rows[*place];
    for (int n = 0; n < 2; ++n) {
      for (int v = 0; v < kVectors; ++v) {
        const Vector f = at<Width>(row.F[n] + v * kWidth);
        for (int r = 0; r < kRows; ++r) sum[r][v] += row.F[n][kFirst + r] * f;
        if (!kEdge) continue;
        ninth[v] += row.tail[n] * f;
        g[v] += row.r[n] * f;
      }
      corner += row.tail[n] * row.tail[n];
      g_corner += row.tail[n] * row.r[n];
    }
  }
  for (int v = 0; v < kVectors; ++v) {
    for (int r = 0; r < kRows; ++r) at<Width>(U + (kFirst + r) * kRow + v * kWidth) = sum[r][v];
    if (!kEdge) continue;
    at<Width>(U + 8 * kRow + v * kWidth) = ninth[v];
    at<Width>(sums.g + v * kWidth) = g[v];
    for (int r = 0; r < kWidth; ++r) U[(v * kWidth + r) * kRow + 8] = ninth[v][r];
  }
  if (!kEdge) return;
  U[8 * kRow + 8] = corner;
  sums.g[8] = g_corner;
}

// AVX-512 holds the sums of a camera in registers; AVX2 a half.
template <typename Width>
RAYLIGN_INLINE void add_camera(const CameraRows* rows,
                               const std::int32_t* begin,
                               const std::int32_t* end,
                               CameraSums& sums) {
  if (std::is_same_v<Width, Eight>) {
    add_sweep<Width, 0, 8, true>(rows, begin, end, sums);
  } else {
    add_sweep<Width, 0, 4, false>(rows, begin, end, sums);
    add_sweep<Width, 4, 8, false>(rows, begin, end, sums);
    add_sweep<Width, 8, 8, true>(rows, begin, end, sums);
  }
}

template <typename Width>
RAYLIGN_INLINE double linearize_windows(const Observations& observations,
                                        std::int64_t begin,
                                        std::int64_t end,
                                        const CameraPacket* packets,
                                        const double* X,
                                        const Loss* loss,
                                        ObservationJacobian* J,
                                        LandmarkBlock* blocks,
                                        CameraSums* cameras,
                                        std::int32_t first_camera,
                                        CameraRows* scratch) {
  double cost = 0.0;
  for (std::int64_t w = begin; w < end; ++w) {
    const std::int64_t first = observations.starts[observations.windows[w]];
    for (auto j = observations.windows[w]; j < observations.windows[w + 1]; ++j) {
      CameraRows* rows = scratch + (observations.starts[j] - first);
      if (!linearize_landmark(observations, j, packets, X, loss, J, blocks, rows, cost)) return NAN;
    }
    const std::int32_t* places = observations.places + first;
    std::int32_t visited = 0;
    for (auto v = observations.window_visits[w]; v < observations.window_visits[w + 1]; ++v) {
      const CameraVisit& visit = observations.visits[v];
      add_camera<Width>(scratch, places + visited, places + visit.end,
                        cameras[visit.camera - first_camera]);
      visited = visit.end;
    }
  }
  return 0.5 * cost;
}

RAYLIGN_CLONES double narrow_body(const Observations& observations,
                                  std::int64_t begin,
                                  std::int64_t end,
                                  const CameraPacket* packets,
                                  const double* X,
                                  const Loss* loss,
                                  ObservationJacobian* J,
                                  LandmarkBlock* blocks,
                                  CameraSums* cameras,
                                  std::int32_t first_camera,
                                  CameraRows* scratch) {
  return linearize_windows<Four>(observations, begin, end, packets, X, loss, J, blocks, cameras,
                                 first_camera, scratch);
}

RAYLIGN_AVX512 double wide_body(const Observations& observations,
                                std::int64_t begin,
                                std::int64_t end,
                                const CameraPacket* packets,
                                const double* X,
                                const Loss* loss,
                                ObservationJacobian* J,
                                LandmarkBlock* blocks,
                                CameraSums* cameras,
                                std::int32_t first_camera,
                                CameraRows* scratch) {
  return linearize_windows<Eight>(observations, begin, end, packets, X, loss, J, blocks, cameras,
                                  first_camera, scratch);
}

}  // namespace

Linearize* narrow_linearize() { return narrow_body; }

Linearize* wide_linearize() { return has_avx512() ? wide_body : nullptr; }

double linearize(const Observations& observations,
                 std::int64_t begin,
                 std::int64_t end,
                 const CameraPacket* packets,
                 const double* X,
                 const Loss* loss,
                 ObservationJacobian* J,
                 LandmarkBlock* blocks,
                 CameraSums* cameras,
                 std::int32_t first_camera,
                 CameraRows* scratch) {
  Linearize* const body = has_avx512() ? wide_body : narrow_body;
  return body(observations, begin, end, packets, X, loss, J, blocks, cameras, first_camera,
              scratch);
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
