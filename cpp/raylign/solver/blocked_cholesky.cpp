// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/blocked_cholesky.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "raylign/solver/blas.h"
#include "raylign/solver/cholesky_kernels.h"
#include "raylign/solver/lapack.h"

namespace raylign {
namespace {

constexpr int kPanel = 128;
constexpr int kRows = 256;  // of a panel, solved by one task

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;

int num_parts(int size, int part) { return (size + part - 1) / part; }

class BlockedCholesky {
 public:
  BlockedCholesky(double* A, int n, ThreadPool& pool) : A_(A), n_(n), pool_(pool) {}

  bool run() {
    for (int first = 0; first < n_; first += kPanel) {
      const int width = std::min(kPanel, n_ - first);
      int info = 0;
      dpotrf_("L", &width, at(first, first), &n_, &info);
      // OpenBLAS compares pivots with <= 0: a NaN goes through
      if (info != 0 || !diagonal_is_finite(first, width)) return false;
      const int rest = first + width;
      pool_.run(num_parts(n_ - rest, kRows), [&](int part) { solve_rows(first, width, part); });
      pool_.run(num_parts(n_ - rest, kPanel),
                [&](int part) { update_columns(first, width, part); });
    }
    return true;
  }

 private:
  double* at(int row, int column) { return A_ + std::int64_t{column} * n_ + row; }

  bool diagonal_is_finite(int first, int width) {
    for (int k = first; k < first + width; ++k) {
      if (!std::isfinite(*at(k, k))) return false;
    }
    return true;
  }

  // L_ik = A_ik L_kkᵀ⁻¹
  void solve_rows(int first, int width, int part) {
    const int row = first + width + part * kRows;
    const int count = std::min(kRows, n_ - row);
    dtrsm_("R", "L", "T", "N", &count, &width, &kOne, at(first, first), &n_, at(row, first), &n_);
  }

  // A_ij −= L_ik L_jkᵀ of the block column j, the triangle above its diagonal too.
  void update_columns(int first, int width, int part) {
    const int column = first + width + part * kPanel;
    const int count = std::min(kPanel, n_ - column);
    const int rows = n_ - column;
    dgemm_("N", "T", &rows, &count, &width, &kMinusOne, at(column, first), &n_, at(column, first),
           &n_, &kOne, at(column, column), &n_);
  }

  double* A_;
  int n_;
  ThreadPool& pool_;
};

}  // namespace

bool factor_cholesky(double* A, int n, ThreadPool& pool) {
  if (n >= kMinBlocked) return BlockedCholesky(A, n, pool).run();
  return factor_in_registers(A, n);
}

}  // namespace raylign
