// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/dense_cholesky.h"

#include <algorithm>
#include <cmath>

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotrs_(const char* uplo,
             const int* n,
             const int* nrhs,
             const double* a,
             const int* lda,
             double* b,
             const int* ldb,
             int* info);
}

namespace raylign::native {

DenseCholesky::DenseCholesky(const SchurSystem& system)
    : system_(system), cameras_(system.cameras()) {
  const auto n = static_cast<std::size_t>(cameras_.num_columns());
  matrix_.resize(n * n);
}

// Block (i, k), i <= k, of the upper triangle becomes rows k, columns i of the lower one.
void DenseCholesky::fill() {
  const SchurPattern& pattern = system_.pattern();
  const std::int64_t n = cameras_.num_columns();
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    const std::int64_t first = cameras_.offset(i);
    std::fill(matrix_.begin() + first * n, matrix_.begin() + (first + cameras_.size(i)) * n, 0.0);
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      const std::int32_t k = pattern.columns[b];
      double* out = matrix_.data() + first * n + cameras_.offset(k);
      for (int a = 0; a < cameras_.size(i); ++a) {
        std::copy_n(system_.blocks()[b].values + a * kRow, cameras_.size(k), out + a * n);
      }
    }
  }
}

LmSolve DenseCholesky::solve(double* delta) {
  fill();
  system_.copy_rhs(delta);
  const int n = cameras_.num_columns();
  if (n == 0) return {true};
  const int one = 1;
  int info = 0;
  dpotrf_("L", &n, matrix_.data(), &n, &info);
  if (info != 0) return {false};
  dpotrs_("L", &n, &one, matrix_.data(), &n, delta, &n, &info);
  return {info == 0 && std::all_of(delta, delta + n, [](double x) { return std::isfinite(x); })};
}

}  // namespace raylign::native
