// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_kernels.h"

#include <type_traits>

#include "raylign/bundle/native/landmark_group.h"

namespace raylign::native {
namespace {

// Zᵀ = (E W)ᵀ F, F = [a × A | −w A | I], of four observations.
template <typename Point>
RAYLIGN_INLINE void eliminate(Point kind,
                              const Householder<D4>& H,
                              const JacobianOf<D4>& J,
                              const D4* W,
                              const D4* X,
                              const D4* c,
                              double* const* out) {
  const D4 w = weight(kind, X);
  D4 a[3];
  ray(kind, X, c, a);
  D4 point[6];
  point_rows(kind, H, J.A, c, point);
  D4 E[2][3];
  D4 F[2][9];
  for (int row = 0; row < 2; ++row) {
    multiply_transposed(W, point + 3 * row, E[row]);
    cross(a, J.A + 3 * row, F[row]);
    for (int k = 0; k < 3; ++k) F[row][3 + k] = -w * J.A[3 * row + k];
    for (int k = 0; k < 3; ++k) F[row][6 + k] = J.I[3 * row + k];
  }
  D4 numbers[28];
  for (int m = 0; m < 3; ++m) {
    for (int k = 0; k < 8; ++k) numbers[8 * m + k] = E[0][m] * F[0][k] + E[1][m] * F[1][k];
    numbers[24 + m] = E[0][m] * F[0][8] + E[1][m] * F[1][8];
  }
  numbers[27] = D4{};
  scatter<28>(numbers, out);
}

// rhs += Z y.
RAYLIGN_INLINE void add_rhs(const Elimination& Z, const double* y, double* rhs) {
  for (int v = 0; v < 8; v += 4) {
    Four::Vector sum = at<Four>(rhs + v);
    for (int m = 0; m < 3; ++m) sum += y[m] * at<Four>(Z.Z[m] + v);
    at<Four>(rhs + v) = sum;
  }
  rhs[8] += Z.tail[0] * y[0] + Z.tail[1] * y[1] + Z.tail[2] * y[2];
}

// Rows [kFirst, kLast) < 8 of S −= Σ Z_i Z_kᵀ, columns 0 … 7, and with kEdge the ninth row and the
// ninth column: the innermost loop of bundle adjustment. S stays in registers.
template <typename Width, int kFirst, int kLast, bool kEdge>
RAYLIGN_INLINE void subtract_sweep(const Elimination* Z_i,
                                   const Elimination* Z_k,
                                   const Product* product,
                                   const Product* end,
                                   double* S) {
  using Vector = typename Width::Vector;
  constexpr int kWidth = sizeof(Vector) / sizeof(double);
  constexpr int kVectors = 8 / kWidth;
  constexpr int kRows = kLast - kFirst;
  Vector sum[kRows + 1][kVectors];
  Vector row[kVectors];
  Vector column[kVectors];
  Four::Vector corner = {S[8 * kRow + 8], 0.0, 0.0, 0.0};
  for (int v = 0; v < kVectors; ++v) {
    for (int r = 0; r < kRows; ++r) sum[r][v] = at<Width>(S + (kFirst + r) * kRow + v * kWidth);
    row[v] = at<Width>(S + 8 * kRow + v * kWidth);
    for (int r = 0; r < kWidth; ++r) column[v][r] = S[(v * kWidth + r) * kRow + 8];
  }
  for (; product != end; ++product) {
    const Elimination& x = Z_i[product->i];
    const Elimination& y = Z_k[product->k];
    for (int m = 0; m < 3; ++m) {
      for (int v = 0; v < kVectors; ++v) {
        const Vector z = at<Width>(y.Z[m] + v * kWidth);
        for (int r = 0; r < kRows; ++r) sum[r][v] -= x.Z[m][kFirst + r] * z;
        if (!kEdge) continue;
        row[v] -= x.tail[m] * z;
        column[v] -= y.tail[m] * at<Width>(x.Z[m] + v * kWidth);
      }
    }
    if (kEdge) corner -= at<Four>(x.tail) * at<Four>(y.tail);
  }
  for (int v = 0; v < kVectors; ++v) {
    for (int r = 0; r < kRows; ++r) at<Width>(S + (kFirst + r) * kRow + v * kWidth) = sum[r][v];
    if (!kEdge) continue;
    at<Width>(S + 8 * kRow + v * kWidth) = row[v];
    for (int r = 0; r < kWidth; ++r) S[(v * kWidth + r) * kRow + 8] = column[v][r];
  }
  if (kEdge) S[8 * kRow + 8] = corner[0] + corner[1] + corner[2];
}

// AVX-512 holds a block in registers; AVX2 a half.
template <typename Width>
RAYLIGN_INLINE void subtract_products(const Elimination* Z_i,
                                      const Elimination* Z_k,
                                      const Product* begin,
                                      const Product* end,
                                      Block& block) {
  double* S = block.values;
  if (std::is_same_v<Width, Eight>) {
    subtract_sweep<Width, 0, 8, true>(Z_i, Z_k, begin, end, S);
  } else {
    subtract_sweep<Width, 0, 4, false>(Z_i, Z_k, begin, end, S);
    subtract_sweep<Width, 4, 8, false>(Z_i, Z_k, begin, end, S);
    subtract_sweep<Width, 8, 8, true>(Z_i, Z_k, begin, end, S);
  }
}

template <typename Width>
RAYLIGN_INLINE void subtract_visits(const ProductWindows& plan,
                                    const ProductWindow& window,
                                    RowRange rows,
                                    const SchurBlocks& S,
                                    const Elimination* Z) {
  const Product* products = plan.products + window.products_begin;
  std::int32_t begin = 0;
  for (auto v = window.visits_begin; v < window.visits_end; ++v) {
    const BlockVisit& visit = plan.visits[v];
    if (visit.row >= rows.end) return;
    if (visit.row >= rows.begin) {
      subtract_products<Width>(Z, Z, products + begin, products + visit.products_end,
                               S.blocks[visit.block]);
    }
    begin = visit.products_end;
  }
}

// The block rows of one track that no plan lists.
template <typename Width>
RAYLIGN_INLINE void subtract_track(const std::int32_t* track,
                                   std::int64_t length,
                                   RowRange rows,
                                   const SchurBlocks& S,
                                   const Elimination* Z) {
  const Product itself = {0, 0};
  for (std::int64_t a = 0; a < length && track[a] < rows.end; ++a) {
    if (track[a] < rows.begin || S.active[track[a]] == 0) continue;
    std::int64_t block = S.starts[track[a]];
    for (std::int64_t b = a; b < length; ++b) {
      if (S.active[track[b]] == 0) continue;
      if (S.diagonal_only && track[b] != track[a]) break;
      while (S.columns[block] < track[b]) ++block;
      subtract_products<Width>(Z + a, Z + b, &itself, &itself + 1, S.blocks[block]);
      if (a == b || track[a] != track[b]) continue;
      subtract_products<Width>(Z + b, Z + a, &itself, &itself + 1, S.blocks[block]);
    }
  }
}

// Z of the observations of four landmarks by cameras from the first row on, into the scratch of a
// window that begins at `first`; the right-hand side of the rows.
template <typename Point, typename Camera>
RAYLIGN_INLINE void eliminate_group(Point kind,
                                    Camera camera_kind,
                                    const DampedProblem& problem,
                                    const Group& group,
                                    RowRange rows,
                                    const SchurBlocks& S,
                                    std::int64_t first,
                                    Elimination* Z) {
  const std::int32_t* cameras = problem.observations.camera;
  D4 X[Point::kStride];
  gather_points(kind, group, problem.X, X);
  const auto H = tangent_at(kind, X);
  D4 W[6];
  gather_records<6>(group, problem.factors, W);
  D4 block[9];
  gather_records<9>(group, problem.landmarks, block);
  D4 y[3];
  multiply_transposed(W, block + 6, y);
  for (std::int64_t step = 0; step < group.longest; ++step) {
    std::int64_t q[4];
    observations_at(group, step, q);
    Elimination unused;
    Elimination* out[4];
    double* records[4];
    bool is_used = false;
    for (int lane = 0; lane < 4; ++lane) {
      const std::int32_t i = cameras[q[lane]];
      const bool has_row = group.has(lane, step) && i >= rows.begin && S.active[i] != 0;
      is_used = is_used || has_row;
      out[lane] = has_row ? Z + (q[lane] - first) : &unused;
      records[lane] = out[lane]->Z[0];
    }
    if (!is_used) continue;
    CameraLanes camera;
    gather_cameras(camera_kind, problem.packets, cameras, q, camera);
    JacobianOf<D4> J;
    jacobians_at(kind, camera_kind, problem.J, q, camera, X, J);
    eliminate(kind, H, J, W, X, camera.c, records);
    for (int lane = 0; lane < 4; ++lane) {
      const std::int32_t i = cameras[q[lane]];
      if (out[lane] == &unused || i >= rows.end) continue;
      const double y_lane[3] = {y[0][lane], y[1][lane], y[2][lane]};
      add_rhs(*out[lane], y_lane, S.rhs + std::int64_t{i} * kRow);
    }
  }
}

// Whether a landmark of the group has products in the rows.
RAYLIGN_INLINE bool touches(const Observations& observations, const Group& group, RowRange rows) {
  for (int lane = 0; lane < 4; ++lane) {
    if (observations.camera[group.first[lane]] < rows.end &&
        observations.camera[group.last[lane]] >= rows.begin) {
      return true;
    }
  }
  return false;
}

template <typename Point, typename Camera>
RAYLIGN_INLINE void eliminate_landmarks(Point kind,
                                        Camera camera_kind,
                                        const DampedProblem& problem,
                                        const ProductWindow& window,
                                        RowRange rows,
                                        const SchurBlocks& S,
                                        Elimination* Z) {
  const std::int64_t first = problem.observations.starts[window.landmark_begin];
  for (auto j = window.landmark_begin; j < window.landmark_end; j += 4) {
    const Group group = group_at(problem.observations, j, window.landmark_end);
    if (!touches(problem.observations, group, rows)) continue;
    eliminate_group(kind, camera_kind, problem, group, rows, S, first, Z);
  }
}

// The one switch over cameras.
template <typename Point>
RAYLIGN_INLINE void eliminate_cameras(Point kind,
                                      const DampedProblem& problem,
                                      const ProductWindow& window,
                                      RowRange rows,
                                      const SchurBlocks& S,
                                      Elimination* Z) {
  switch (problem.observations.camera_kind) {
    case CameraKind::PINHOLE:
      return eliminate_landmarks(kind, PinholeKind{}, problem, window, rows, S, Z);
    case CameraKind::RADTAN:
      return eliminate_landmarks(kind, RadtanKind{}, problem, window, rows, S, Z);
    case CameraKind::BAL:
      break;
  }
  eliminate_landmarks(kind, BalKind{}, problem, window, rows, S, Z);
}

// By value: in registers, where no store through a vector can be thought to change them.
RAYLIGN_CLONES void eliminate_window(
    DampedProblem problem, ProductWindow window, RowRange rows, SchurBlocks S, Elimination* Z) {
  if (problem.observations.point_kind == PointKind::HOMOGENEOUS) {
    eliminate_cameras(HomogeneousPoint{}, problem, window, rows, S, Z);
  } else {
    eliminate_cameras(XyzPoint{}, problem, window, rows, S, Z);
  }
}

// By value, as above.
template <typename Width>
RAYLIGN_INLINE void subtract_windows(DampedProblem problem,
                                     ProductWindows plan,
                                     RowRange rows,
                                     SchurBlocks S,
                                     Elimination* scratch) {
  const Observations& observations = problem.observations;
  for (std::int64_t w = 0; w < plan.count; ++w) {
    const ProductWindow& window = plan.windows[w];
    eliminate_window(problem, window, rows, S, scratch);
    if (window.is_planned) {
      subtract_visits<Width>(plan, window, rows, S, scratch);
    } else {
      const std::int64_t first = observations.starts[window.landmark_begin];
      const std::int64_t length = observations.starts[window.landmark_end] - first;
      subtract_track<Width>(observations.camera + first, length, rows, S, scratch);
    }
  }
}

RAYLIGN_CLONES void subtract_narrow(const DampedProblem& problem,
                                    const ProductWindows& plan,
                                    RowRange rows,
                                    const SchurBlocks& S,
                                    Elimination* scratch) {
  subtract_windows<Four>(problem, plan, rows, S, scratch);
}

RAYLIGN_AVX512 void subtract_wide(const DampedProblem& problem,
                                  const ProductWindows& plan,
                                  RowRange rows,
                                  const SchurBlocks& S,
                                  Elimination* scratch) {
  subtract_windows<Eight>(problem, plan, rows, S, scratch);
}

}  // namespace

SubtractLandmarks* narrow_subtract_landmarks() { return subtract_narrow; }

SubtractLandmarks* wide_subtract_landmarks() { return has_avx512() ? subtract_wide : nullptr; }

void subtract_landmarks(const DampedProblem& problem,
                        const ProductWindows& plan,
                        RowRange rows,
                        const SchurBlocks& S,
                        Elimination* scratch) {
  (has_avx512() ? subtract_wide : subtract_narrow)(problem, plan, rows, S, scratch);
}

RAYLIGN_CLONES void fold_block(const Block& M,
                               const Block& B_i,
                               const Block& B_k,
                               int rows,
                               int columns,
                               double* out,
                               std::int64_t stride) {
  Block P;
  for (int row = 0; row < 9; ++row) {
    Lanes sum[kLanes] = {};
    for (int m = 0; m < 9; ++m) {
      for (int v = 0; v < kLanes; ++v) {
        sum[v] += M.values[row * kRow + m] * lanes(B_k.values + m * kRow)[v];
      }
    }
    for (int v = 0; v < kLanes; ++v) lanes(P.values + row * kRow)[v] = sum[v];
  }
  for (int a = 0; a < rows; ++a) {
    alignas(32) double Q[kRow];
    Lanes sum[kLanes] = {};
    for (int row = 0; row < 9; ++row) {
      for (int v = 0; v < kLanes; ++v) {
        sum[v] += B_i.values[row * kRow + a] * lanes(P.values + row * kRow)[v];
      }
    }
    for (int v = 0; v < kLanes; ++v) lanes(Q)[v] = sum[v];
    for (int k = 0; k < columns; ++k) out[a * stride + k] = Q[k];
  }
}

}  // namespace raylign::native
