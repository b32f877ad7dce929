// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_factor.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raylign::native {

DirectSolver::DirectSolver(LinearSolverType type,
                           const SolverContext& context,
                           SchurPattern pattern,
                           std::unique_ptr<SchurFactor> factor)
    : type_(type), system_(context, std::move(pattern)), factor_(std::move(factor)) {}

LmSolve DirectSolver::solve(const DampedProblem& problem, double* delta) {
  system_.form(problem);
  if (!factor_->factor(system_)) return {false};
  const CameraBlocks& cameras = system_.cameras();
  pack(cameras, system_.rhs().data(), delta);
  factor_->solve(delta);
  return {
      std::all_of(delta, delta + cameras.num_columns(), [](double x) { return std::isfinite(x); })};
}

}  // namespace raylign::native
