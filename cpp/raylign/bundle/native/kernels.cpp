// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/kernels.h"

#include <cmath>
#include <type_traits>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/landmark_group.h"

namespace raylign::native {
namespace {

// Rounds J of one observation; adds to the camera's gradient what rounding takes from Fᵀr, because
// a gradient of rounded numbers vanishes elsewhere than the true one.
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

// The four J of a step into the table, where there is one; `sight` holds them rounded after it.
template <typename Point>
RAYLIGN_INLINE void store_jacobians(Point kind,
                                    const State& state,
                                    const Group& group,
                                    std::int64_t step,
                                    const std::int64_t* q,
                                    const LinearizationTables& out,
                                    Sight& sight) {
  if (out.J.exact == nullptr && out.J.rounded == nullptr) return;
  ObservationJacobian J[4];
  double* rows[4];
  for (int lane = 0; lane < 4; ++lane) {
    const bool is_kept = out.J.rounded == nullptr && group.has(lane, step);
    rows[lane] = reinterpret_cast<double*>(is_kept ? out.J.exact + q[lane] : J + lane);
  }
  D4 numbers[12];
  for (int k = 0; k < 6; ++k) numbers[k] = sight.J.A[k];
  for (int k = 0; k < 6; ++k) numbers[6 + k] = sight.J.I[k];
  scatter<12>(numbers, rows);
  if (out.J.rounded == nullptr) return;
  for (int lane = 0; lane < 4; ++lane) {
    if (!group.has(lane, step)) continue;
    const std::int32_t i = state.observations.camera[q[lane]];
    const double r[2] = {sight.r[0][lane], sight.r[1][lane]};
    store_rounded(kind, J[lane], state.X + std::int64_t{Point::kStride} * group.landmark[lane],
                  state.packets[i].c, r, out.J.rounded[q[lane]],
                  out.cameras[i - out.first_camera].g);
    for (int k = 0; k < 6; ++k) sight.J.A[k][lane] = J[lane].A[k];
    for (int k = 0; k < 6; ++k) sight.J.I[k][lane] = J[lane].I[k];
  }
}

// F = [a × A | −w A | I] and r of four observations, into the rows of a window that begins at
// `first`.
template <typename Point>
RAYLIGN_INLINE void write_rows(Point kind,
                               const Group& group,
                               std::int64_t step,
                               const std::int64_t* q,
                               const CameraLanes& camera,
                               const D4* X,
                               const Sight& sight,
                               std::int64_t first,
                               CameraRows* rows) {
  const D4 w = weight(kind, X);
  D4 a[3];
  ray(kind, X, camera.c, a);
  D4 numbers[20];
  for (int row = 0; row < 2; ++row) {
    D4* f = numbers + 8 * row;
    const D4* A = sight.J.A + 3 * row;
    const D4* I = sight.J.I + 3 * row;
    cross(a, A, f);
    for (int k = 0; k < 3; ++k) f[3 + k] = -w * A[k];
    f[6] = I[0];
    f[7] = I[1];
    numbers[16 + row] = I[2];
    numbers[18 + row] = sight.r[row];
  }
  CameraRows unused;
  double* out[4];
  for (int lane = 0; lane < 4; ++lane) {
    out[lane] = (group.has(lane, step) ? rows + (q[lane] - first) : &unused)->F[0];
  }
  scatter<20>(numbers, out);
}

// Four landmarks: J, H, g, and F for the cameras. Adds to the cost: NaN when a point lies in a
// camera's plane.
template <typename Point, typename Camera>
RAYLIGN_INLINE void linearize_group(Point kind,
                                    Camera camera_kind,
                                    const State& state,
                                    const Group& group,
                                    const LinearizationTables& out,
                                    std::int64_t first,
                                    D4& cost) {
  D4 X[Point::kStride];
  gather_points(kind, group, state.X, X);
  const auto H = tangent_at(kind, X);
  LandmarkBlockOf<D4> block = {};
  for (std::int64_t step = 0; step < group.longest; ++step) {
    std::int64_t q[4];
    observations_at(group, step, q);
    CameraLanes camera;
    gather_cameras(camera_kind, state.packets, state.observations.camera, q, camera);
    Sight sight;
    look<true>(kind, camera_kind, state, group, step, q, camera, X, sight);
    cost += sight.rho;
    D4 E[6];
    point_rows(kind, H, sight.J.A, camera.c, E);
    add_gradient(E, sight.r, block);
    store_jacobians(kind, state, group, step, q, out, sight);
    point_rows(kind, H, sight.J.A, camera.c, E);
    add_hessian(E, block);
    write_rows(kind, group, step, q, camera, X, sight, first, out.scratch);
  }
  D4 numbers[9];
  for (int k = 0; k < 6; ++k) numbers[k] = block.H[k];
  for (int k = 0; k < 3; ++k) numbers[6 + k] = block.g[k];
  scatter_records<9>(group, numbers, out.blocks);
}

template <typename Point, typename Camera>
RAYLIGN_INLINE double linearize_groups(
    Point kind, Camera camera_kind, const State& state, std::int64_t w, LinearizationTables out) {
  const Observations& observations = state.observations;
  const std::int64_t end = observations.windows[w + 1];
  const std::int64_t first = observations.starts[observations.windows[w]];
  D4 cost = {};
  for (auto j = observations.windows[w]; j < end; j += 4) {
    linearize_group(kind, camera_kind, state, group_at(observations, j, end), out, first, cost);
  }
  return sum_of(cost);
}

// The one switch over cameras.
template <typename Point>
RAYLIGN_INLINE double linearize_cameras(Point kind,
                                        const State& state,
                                        std::int64_t w,
                                        const LinearizationTables& out) {
  switch (state.observations.camera_kind) {
    case CameraKind::PINHOLE:
      return linearize_groups(kind, PinholeKind{}, state, w, out);
    case CameraKind::RADTAN:
      return linearize_groups(kind, RadtanKind{}, state, w, out);
    case CameraKind::BAL:
      break;
  }
  return linearize_groups(kind, BalKind{}, state, w, out);
}

// The landmarks of window w; Σ ρ(‖r‖²). By value: in registers, where no store through a vector
// can be thought to change them.
RAYLIGN_CLONES double linearize_window(State state, std::int64_t w, LinearizationTables out) {
  if (state.observations.point_kind == PointKind::HOMOGENEOUS) {
    return linearize_cameras(HomogeneousPoint{}, state, w, out);
  }
  return linearize_cameras(XyzPoint{}, state, w, out);
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

// By value, as above.
template <typename Width>
RAYLIGN_INLINE void add_cameras(Observations observations,
                                std::int64_t w,
                                LinearizationTables out) {
  const std::int32_t* places = observations.places + observations.starts[observations.windows[w]];
  std::int32_t visited = 0;
  for (auto v = observations.window_visits[w]; v < observations.window_visits[w + 1]; ++v) {
    const CameraVisit& visit = observations.visits[v];
    add_camera<Width>(out.scratch, places + visited, places + visit.end,
                      out.cameras[visit.camera - out.first_camera]);
    visited = visit.end;
  }
}

RAYLIGN_CLONES void add_cameras_narrow(const Observations& observations,
                                       std::int64_t w,
                                       const LinearizationTables& out) {
  add_cameras<Four>(observations, w, out);
}

RAYLIGN_AVX512 void add_cameras_wide(const Observations& observations,
                                     std::int64_t w,
                                     const LinearizationTables& out) {
  add_cameras<Eight>(observations, w, out);
}

template <typename AddCameras>
double linearize_by(AddCameras* add_cameras_of,
                    const State& state,
                    std::int64_t begin,
                    std::int64_t end,
                    const LinearizationTables& out) {
  double cost = 0.0;
  for (std::int64_t w = begin; w < end; ++w) {
    cost += linearize_window(state, w, out);
    add_cameras_of(state.observations, w, out);
  }
  return 0.5 * cost;
}

double narrow_body(const State& state,
                   std::int64_t begin,
                   std::int64_t end,
                   const LinearizationTables& out) {
  return linearize_by(add_cameras_narrow, state, begin, end, out);
}

double wide_body(const State& state,
                 std::int64_t begin,
                 std::int64_t end,
                 const LinearizationTables& out) {
  return linearize_by(add_cameras_wide, state, begin, end, out);
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
