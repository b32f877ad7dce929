// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/kernels.h"

#include <cmath>
#include <type_traits>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/camera_kinds.h"
#include "raylign/bundle/native/landmark_math.h"
#include "raylign/bundle/native/point_kinds.h"

// GCC 12 takes filling a vector lane by lane, where the machine has none so wide, for a read.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

namespace raylign::native {
namespace {

// Stores J and rounds it; adds to the camera's gradient what rounding takes from Fᵀr, because a
// gradient of rounded numbers vanishes elsewhere than the true one.
template <typename Point>
RAYLIGN_INLINE void store_rounded(Point kind,
                                  ObservationJacobian& J,
                                  const double* X,
                                  const double* c,
                                  const double* r,
                                  RoundedJacobian& out,
                                  double* g) {
  double lost_A[6];
  double lost_I[6];
  for (int k = 0; k < 6; ++k) {
    out.A[k] = static_cast<float>(J.A[k]);
    out.I[k] = static_cast<float>(J.I[k]);
    lost_A[k] = J.A[k] - out.A[k];
    lost_I[k] = J.I[k] - out.I[k];
    J.A[k] = out.A[k];
    J.I[k] = out.I[k];
  }
  const double w = weight(kind, X);
  double a[3];
  ray(kind, X, c, a);
  double force[3];  // of the lost part of A; Fᵀr = [a × Aᵀr; −w Aᵀr; Iᵀr]
  double torque[3];
  for (int k = 0; k < 3; ++k) force[k] = lost_A[k] * r[0] + lost_A[3 + k] * r[1];
  cross(a, force, torque);
  for (int k = 0; k < 3; ++k) g[k] += torque[k];
  for (int k = 0; k < 3; ++k) g[3 + k] -= w * force[k];
  for (int k = 0; k < 3; ++k) g[6 + k] += lost_I[k] * r[0] + lost_I[3 + k] * r[1];
}

// F = [a × A | −w A | I] and r.
template <typename Point>
RAYLIGN_INLINE void write_rows(Point kind,
                               const ObservationJacobian& J,
                               const double* X,
                               const double* c,
                               const double* r,
                               CameraRows& rows) {
  const double w = weight(kind, X);
  double a[3];
  ray(kind, X, c, a);
  for (int row = 0; row < 2; ++row) {
    double* f = rows.F[row];
    const double* A = J.A + 3 * row;
    cross(a, A, f);
    for (int k = 0; k < 3; ++k) f[3 + k] = -w * A[k];
    f[6] = J.I[3 * row];
    f[7] = J.I[3 * row + 1];
    rows.tail[row] = J.I[3 * row + 2];
    rows.r[row] = r[row];
  }
}

// One landmark: J, H, g, and F for the cameras. Adds to the cost; false when there is none.
template <typename Point, typename Camera>
RAYLIGN_INLINE bool linearize_landmark(Point kind,
                                       Camera camera_kind,
                                       const State& state,
                                       std::int64_t j,
                                       const LinearizationTables& out,
                                       CameraRows* rows,
                                       double& cost) {
  const Observations& observations = state.observations;
  const double* X_j = state.X + std::int64_t{Point::kStride} * j;
  const Householder H = tangent_at(kind, X_j);
  LandmarkBlock block = {};
  for (std::int64_t q = observations.starts[j]; q < observations.starts[j + 1]; ++q) {
    const std::int32_t i = observations.camera[q];
    const CameraPacket& camera = state.packets[i];
    double P[3];
    transform(kind, camera, X_j, P);
    typename Camera::Projection p;
    if (!project(camera_kind, camera, P, p)) return false;
    double r[2];
    residual(camera_kind, camera, p, observations.uv + 2 * q, r);
    ObservationJacobian J_q;
    jacobian(camera_kind, camera, p, J_q);
    const double s = r[0] * r[0] + r[1] * r[1];
    cost += state.loss == nullptr ? s : apply_loss(*state.loss, s, J_q, r);
    double E[6];
    point_rows(kind, H, J_q.A, camera.c, E);
    add_gradient(E, r, block);
    if (out.J.rounded == nullptr) {
      out.J.exact[q] = J_q;
    } else {
      double* g = out.cameras[i - out.first_camera].g;
      store_rounded(kind, J_q, X_j, camera.c, r, out.J.rounded[q], g);
      point_rows(kind, H, J_q.A, camera.c, E);
    }
    add_hessian(E, block);
    write_rows(kind, J_q, X_j, camera.c, r, *rows++);
  }
  out.blocks[j] = block;
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

template <typename Width, typename Point, typename Camera>
RAYLIGN_INLINE double linearize_windows(Point kind,
                                        Camera camera_kind,
                                        const State& state,
                                        std::int64_t begin,
                                        std::int64_t end,
                                        const LinearizationTables& out) {
  const Observations& observations = state.observations;
  double cost = 0.0;
  for (std::int64_t w = begin; w < end; ++w) {
    const std::int64_t first = observations.starts[observations.windows[w]];
    for (auto j = observations.windows[w]; j < observations.windows[w + 1]; ++j) {
      CameraRows* rows = out.scratch + (observations.starts[j] - first);
      if (!linearize_landmark(kind, camera_kind, state, j, out, rows, cost)) return NAN;
    }
    const std::int32_t* places = observations.places + first;
    std::int32_t visited = 0;
    for (auto v = observations.window_visits[w]; v < observations.window_visits[w + 1]; ++v) {
      const CameraVisit& visit = observations.visits[v];
      add_camera<Width>(out.scratch, places + visited, places + visit.end,
                        out.cameras[visit.camera - out.first_camera]);
      visited = visit.end;
    }
  }
  return 0.5 * cost;
}

// The one switch over cameras.
template <typename Width, typename Point>
RAYLIGN_INLINE double linearize_points(Point kind,
                                       const State& state,
                                       std::int64_t begin,
                                       std::int64_t end,
                                       const LinearizationTables& out) {
  switch (state.observations.camera_kind) {
    case CameraKind::PINHOLE:
      return linearize_windows<Width>(kind, PinholeKind{}, state, begin, end, out);
    case CameraKind::RADTAN:
      return linearize_windows<Width>(kind, RadtanKind{}, state, begin, end, out);
    case CameraKind::BAL:
      break;
  }
  return linearize_windows<Width>(kind, BalKind{}, state, begin, end, out);
}

// By value: in registers, where no store through a vector can be thought to change them.
template <typename Width>
RAYLIGN_INLINE double linearize_any(State state,
                                    std::int64_t begin,
                                    std::int64_t end,
                                    LinearizationTables out) {
  if (state.observations.point_kind == PointKind::HOMOGENEOUS) {
    return linearize_points<Width>(HomogeneousPoint{}, state, begin, end, out);
  }
  return linearize_points<Width>(XyzPoint{}, state, begin, end, out);
}

RAYLIGN_CLONES double narrow_body(const State& state,
                                  std::int64_t begin,
                                  std::int64_t end,
                                  const LinearizationTables& out) {
  return linearize_any<Four>(state, begin, end, out);
}

RAYLIGN_AVX512 double wide_body(const State& state,
                                std::int64_t begin,
                                std::int64_t end,
                                const LinearizationTables& out) {
  return linearize_any<Eight>(state, begin, end, out);
}

}  // namespace

Linearize* narrow_linearize() { return narrow_body; }

Linearize* wide_linearize() { return has_avx512() ? wide_body : nullptr; }

double linearize(const State& state,
                 std::int64_t begin,
                 std::int64_t end,
                 const LinearizationTables& out) {
  return (has_avx512() ? wide_body : narrow_body)(state, begin, end, out);
}

}  // namespace raylign::native
