// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "raylign/bundle/native/preconditioner.h"
#include "raylign/bundle/native/schur_factor.h"

namespace raylign::native {

/// A Cholesky factor of an earlier S: the cost of a factorisation is shared by several steps. A new
/// one is made when the last system took more than kMaxIterations. Needs the whole S.
class StaleFactor : public SchurPreconditioner {
 public:
  static constexpr int kMaxIterations = 15;

  StaleFactor(const CameraBlocks& cameras, std::unique_ptr<SchurFactor> factor);
  void prepare(const SchurSystem& system, const DampedProblem& problem) override;
  void apply(const double* r, double* z) override;
  void report(int iterations) override { is_stale_ = iterations > kMaxIterations; }

  int num_factorizations() const { return num_factorizations_; }

 private:
  const CameraBlocks& cameras_;
  std::unique_ptr<SchurFactor> factor_;
  BlockJacobi fallback_;  // while S has no factor
  bool has_factor_ = false;
  bool is_stale_ = true;
  int num_factorizations_ = 0;
  std::vector<double> columns_;
};

}  // namespace raylign::native
