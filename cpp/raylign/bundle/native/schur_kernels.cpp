// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_kernels.h"

#include <type_traits>

#include "raylign/bundle/native/point_kinds.h"

// GCC 12 takes filling a vector lane by lane, where the machine has none so wide, for a read.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

namespace raylign::native {
namespace {

// Zᵀ = (E W)ᵀ F; F = [a × A | −w A | I] stays in registers.
template <typename Point>
RAYLIGN_INLINE void eliminate(Point kind,
                              const Householder& H,
                              const ObservationJacobian& J,
                              const double* W,
                              const double* X,
                              const double* c,
                              Elimination& out) {
  const double w = weight(kind, X);
  double a[3];
  ray(kind, X, c, a);
  double point[6];
  point_rows(kind, H, J.A, c, point);
  double E[2][3];
  Four::Vector left[2];
  Four::Vector right[2];
  for (int row = 0; row < 2; ++row) {
    const double* A = J.A + 3 * row;
    const double* I = J.I + 3 * row;
    multiply_transposed(W, point + 3 * row, E[row]);
    left[row] = Four::Vector{a[1] * A[2] - a[2] * A[1], a[2] * A[0] - a[0] * A[2],
                             a[0] * A[1] - a[1] * A[0], -w * A[0]};
    right[row] = Four::Vector{-w * A[1], -w * A[2], I[0], I[1]};
  }
  for (int m = 0; m < 3; ++m) {
    at<Four>(out.Z[m]) = E[0][m] * left[0] + E[1][m] * left[1];
    at<Four>(out.Z[m] + 4) = E[0][m] * right[0] + E[1][m] * right[1];
    out.tail[m] = E[0][m] * J.I[2] + E[1][m] * J.I[5];
  }
  out.tail[3] = 0.0;
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

// Z of a window's observations by cameras from the first row on; the right-hand side of the rows.
template <typename Point>
RAYLIGN_INLINE void eliminate_landmark(Point kind,
                                       const DampedProblem& problem,
                                       std::int64_t j,
                                       RowRange rows,
                                       const SchurBlocks& S,
                                       Elimination* Z) {
  const std::int64_t first = problem.observations.starts[j];
  const std::int64_t length = problem.observations.starts[j + 1] - first;
  const std::int32_t* track = problem.observations.camera + first;
  if (track[0] >= rows.end || track[length - 1] < rows.begin) return;
  const double* X_j = problem.X + std::int64_t{Point::kStride} * j;
  const Householder H = tangent_at(kind, X_j);
  const double* W = problem.factors[j].W;
  double y[3];
  multiply_transposed(W, problem.landmarks[j].g, y);
  for (std::int64_t a = 0; a < length; ++a) {
    const std::int32_t i = track[a];
    if (i < rows.begin || S.active[i] == 0) continue;
    eliminate(kind, H, load(problem.J, first + a), W, X_j, problem.packets[i].c, Z[a]);
    if (i < rows.end) add_rhs(Z[a], y, S.rhs + std::int64_t{i} * kRow);
  }
}

template <typename Width, typename Point>
RAYLIGN_INLINE void subtract_windows(Point kind,
                                     const DampedProblem& problem,
                                     const ProductWindows& plan,
                                     RowRange rows,
                                     const SchurBlocks& S,
                                     Elimination* scratch) {
  const Observations& observations = problem.observations;
  for (std::int64_t w = 0; w < plan.count; ++w) {
    const ProductWindow& window = plan.windows[w];
    const std::int64_t first = observations.starts[window.landmark_begin];
    for (auto j = window.landmark_begin; j < window.landmark_end; ++j) {
      eliminate_landmark(kind, problem, j, rows, S, scratch + (observations.starts[j] - first));
    }
    if (window.is_planned) {
      subtract_visits<Width>(plan, window, rows, S, scratch);
    } else {
      const std::int64_t length = observations.starts[window.landmark_end] - first;
      subtract_track<Width>(observations.camera + first, length, rows, S, scratch);
    }
  }
}

// By value: in registers, where no store through a vector can be thought to change them.
template <typename Width>
RAYLIGN_INLINE void subtract_any(DampedProblem problem,
                                 ProductWindows plan,
                                 RowRange rows,
                                 SchurBlocks S,
                                 Elimination* scratch) {
  if (problem.observations.point_kind == PointKind::HOMOGENEOUS) {
    subtract_windows<Width>(HomogeneousPoint{}, problem, plan, rows, S, scratch);
  } else {
    subtract_windows<Width>(XyzPoint{}, problem, plan, rows, S, scratch);
  }
}

RAYLIGN_CLONES void subtract_narrow(const DampedProblem& problem,
                                    const ProductWindows& plan,
                                    RowRange rows,
                                    const SchurBlocks& S,
                                    Elimination* scratch) {
  subtract_any<Four>(problem, plan, rows, S, scratch);
}

RAYLIGN_AVX512 void subtract_wide(const DampedProblem& problem,
                                  const ProductWindows& plan,
                                  RowRange rows,
                                  const SchurBlocks& S,
                                  Elimination* scratch) {
  subtract_any<Eight>(problem, plan, rows, S, scratch);
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
