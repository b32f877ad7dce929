// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/stale_factor.h"

#include <utility>

namespace raylign::native {

StaleFactor::StaleFactor(const CameraBlocks& cameras, std::unique_ptr<SchurFactor> factor)
    : cameras_(cameras),
      factor_(std::move(factor)),
      fallback_(cameras, Preconditioner::SCHUR_JACOBI),
      columns_(cameras.num_columns()) {}

void StaleFactor::prepare(const SchurSystem& system, const DampedProblem& problem) {
  if (is_stale_ || !has_factor_) {
    has_factor_ = factor_->factor(system);
    is_stale_ = false;
    ++num_factorizations_;
  }
  if (!has_factor_) fallback_.prepare(system, problem);
}

void StaleFactor::apply(const double* r, double* z) {
  if (!has_factor_) return fallback_.apply(r, z);
  pack(cameras_, r, columns_.data());
  factor_->solve(columns_.data());
  unpack(cameras_, columns_.data(), z);
}

}  // namespace raylign::native
