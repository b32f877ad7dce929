// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/dense_cholesky.h"

#include <algorithm>

#include "raylign/solver/blocked_cholesky.h"
#include "raylign/solver/cholesky_kernels.h"

namespace raylign::native {

DenseCholesky::DenseCholesky(const CameraBlocks& cameras, ThreadPool& pool)
    : cameras_(cameras), pool_(pool) {
  const auto n = static_cast<std::size_t>(cameras_.num_columns());
  matrix_.resize(n * n);
}

// Block (i, k), i <= k, of the upper triangle becomes rows k, columns i of the lower one.
void DenseCholesky::fill(const SchurSystem& system) {
  const SchurPattern& pattern = system.pattern();
  const std::int64_t n = cameras_.num_columns();
  pool_.run(pattern.num_cameras(), [&](int i) {
    const std::int64_t first = cameras_.offset(i);
    for (std::int64_t a = first; a < first + cameras_.size(i); ++a) {
      std::fill(matrix_.begin() + a * n + a, matrix_.begin() + (a + 1) * n, 0.0);
    }
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      const std::int32_t k = pattern.columns[b];
      double* out = matrix_.data() + first * n + cameras_.offset(k);
      for (int a = 0; a < cameras_.size(i); ++a) {
        std::copy_n(system.blocks()[b].values + a * kRow, cameras_.size(k), out + a * n);
      }
    }
  });
}

bool DenseCholesky::factor(const SchurSystem& system) {
  fill(system);
  return factor_cholesky(matrix_.data(), cameras_.num_columns(), pool_);
}

void DenseCholesky::solve(double* x) {
  solve_in_registers(matrix_.data(), cameras_.num_columns(), x);
}

}  // namespace raylign::native
