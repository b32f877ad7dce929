// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/cholesky_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "raylign/base/clones.h"
#include "raylign/base/double_lanes.h"

namespace raylign {
namespace {

using native::at;
using native::Eight;
using native::Four;

constexpr int kBlock = 48;     // columns that wait for all columns before them
constexpr int kMinTiles = 32;  // columns: tiles read on into the next column

// A matrix by columns, column k at A + k n.
struct Matrix {
  double* A;
  std::int64_t n;
  double* column(std::int64_t k) const { return A + k * n; }
};

// Rows [i, i + 3 vectors), columns [j, j + kColumns) −= Σ A_ik A_jk over columns k in [begin, end),
// all in registers. Rows and columns beyond the matrix are computed of what stands there and not
// stored.
template <typename Width>
struct Tile {
  using Vector = typename Width::Vector;
  static constexpr int kWidth = sizeof(Vector) / sizeof(double);
  static constexpr int kRows = 3 * kWidth;
  static constexpr int kColumns = kWidth;  // AVX-512 has registers for 24 sums, AVX2 for 12

  RAYLIGN_INLINE void subtract(
      const Matrix& M, std::int64_t begin, std::int64_t end, std::int64_t i, std::int64_t j) {
    const auto rows = static_cast<int>(std::min<std::int64_t>(kRows, M.n - i));
    const auto columns = static_cast<int>(std::min<std::int64_t>(kColumns, M.n - j));
    Vector sum[kColumns][3];
    for (int c = 0; c < kColumns; ++c) {
      for (int v = 0; v < 3; ++v) sum[c][v] = Vector{};
    }
    for (std::int64_t k = begin; k < end; ++k) {
      const double* a = M.column(k) + i;
      const double* b = M.column(k) + j;
      const Vector a0 = at<Width>(a);
      const Vector a1 = at<Width>(a + kWidth);
      const Vector a2 = at<Width>(a + 2 * kWidth);
      for (int c = 0; c < kColumns; ++c) {
        sum[c][0] += a0 * b[c];
        sum[c][1] += a1 * b[c];
        sum[c][2] += a2 * b[c];
      }
    }
    if (rows == kRows && columns == kColumns) {
      for (int c = 0; c < kColumns; ++c) {
        double* out = M.column(j + c) + i;
        for (int v = 0; v < 3; ++v) at<Width>(out + v * kWidth) -= sum[c][v];
      }
      return;
    }
    double values[kColumns][kRows];
    for (int c = 0; c < kColumns; ++c) {
      for (int v = 0; v < 3; ++v) at<Width>(values[c] + v * kWidth) = sum[c][v];
    }
    for (int c = 0; c < columns; ++c) {
      double* out = M.column(j + c) + i;
      for (int r = 0; r < rows; ++r) out[r] -= values[c][r];
    }
  }
};

// L of the square at (j, j) of `size` columns, in place, and the reciprocals of its diagonal.
RAYLIGN_INLINE bool factor_square(const Matrix& M, std::int64_t j, int size, double* inverse) {
  for (int c = 0; c < size; ++c) {
    double* column = M.column(j + c) + j;
    for (int m = 0; m < c; ++m) {
      const double* earlier = M.column(j + m) + j;
      for (int r = c; r < size; ++r) column[r] -= earlier[r] * earlier[c];
    }
    if (!(column[c] > 0.0) || !std::isfinite(column[c])) return false;
    column[c] = std::sqrt(column[c]);
    inverse[c] = 1.0 / column[c];
    for (int r = c + 1; r < size; ++r) column[r] *= inverse[c];
  }
  return true;
}

// One vector of rows below a whole square: A L⁻ᵀ.
template <typename Value, int kSize, typename At>
RAYLIGN_INLINE void solve_rows(
    const Matrix& M, std::int64_t j, const double* inverse, std::int64_t i, const At& value_at) {
  Value x[kSize];
  for (int c = 0; c < kSize; ++c) {
    x[c] = value_at(M.column(j + c) + i);
    for (int m = 0; m < c; ++m) x[c] -= x[m] * M.column(j + m)[j + c];
    x[c] *= inverse[c];
    value_at(M.column(j + c) + i) = x[c];
  }
}

template <typename Width>
RAYLIGN_INLINE bool factor_columns(const Matrix& M, std::int64_t j) {
  using Vector = typename Width::Vector;
  constexpr int kColumns = Tile<Width>::kColumns;
  double inverse[kColumns];
  const auto size = static_cast<int>(std::min<std::int64_t>(kColumns, M.n - j));
  if (!factor_square(M, j, size, inverse)) return false;
  std::int64_t i = j + kColumns;  // there are no rows below a square that is not whole
  for (; i + kColumns <= M.n; i += kColumns) {
    solve_rows<Vector, kColumns>(M, j, inverse, i,
                                 [](double* value) -> Vector& { return at<Width>(value); });
  }
  for (; i < M.n; ++i) {
    solve_rows<double, kColumns>(M, j, inverse, i, [](double* value) -> double& { return *value; });
  }
  return true;
}

template <typename Width>
RAYLIGN_INLINE bool factor(const Matrix M) {
  if (M.n < kMinTiles) {
    double inverse[kMinTiles];
    return factor_square(M, 0, static_cast<int>(M.n), inverse);
  }
  constexpr int kColumns = Tile<Width>::kColumns;
  constexpr int kRows = Tile<Width>::kRows;
  Tile<Width> tile;
  for (std::int64_t first = 0; first < M.n; first += kBlock) {
    const std::int64_t end = std::min<std::int64_t>(M.n, first + kBlock);
    for (auto i = first; first > 0 && i < M.n; i += kRows) {
      for (auto j = first; j < end && j < i + kRows; j += kColumns) {
        tile.subtract(M, 0, first, i, j);
      }
    }
    for (auto j = first; j < end; j += kColumns) {
      for (auto i = j; j > first && i < M.n; i += kRows) tile.subtract(M, first, j, i, j);
      if (!factor_columns<Width>(M, j)) return false;
    }
  }
  return true;
}

RAYLIGN_CLONES bool factor_narrow(double* A, int n) { return factor<Four>({A, n}); }

RAYLIGN_AVX512 bool factor_wide(double* A, int n) { return factor<Eight>({A, n}); }

}  // namespace

bool factor_in_registers(double* A, int n) {
  return (has_avx512() ? factor_wide : factor_narrow)(A, n);
}

RAYLIGN_CLONES void solve_in_registers(const double* L, int n, double* x) {
  for (std::int64_t k = 0; k < n; ++k) {
    const double* column = L + k * n;
    x[k] /= column[k];
    for (std::int64_t r = k + 1; r < n; ++r) x[r] -= column[r] * x[k];
  }
  for (std::int64_t k = n; k-- > 0;) {
    const double* column = L + k * n;
    Four::Vector sums[2] = {};
    std::int64_t r = k + 1;
    for (; r + 8 <= n; r += 8) {
      sums[0] += at<Four>(column + r) * at<Four>(x + r);
      sums[1] += at<Four>(column + r + 4) * at<Four>(x + r + 4);
    }
    const Four::Vector both = sums[0] + sums[1];
    double sum = (both[0] + both[1]) + (both[2] + both[3]);
    for (; r < n; ++r) sum += column[r] * x[r];
    x[k] = (x[k] - sum) / column[k];
  }
}

}  // namespace raylign
