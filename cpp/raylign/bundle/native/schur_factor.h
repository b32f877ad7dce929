// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "raylign/bundle/native/linear_solver.h"
#include "raylign/bundle/native/schur_system.h"

namespace raylign::native {

/// A Cholesky factor of S.
class SchurFactor {
 public:
  virtual ~SchurFactor() = default;
  /// False when S is not positive definite: there is no factor then.
  virtual bool factor(const SchurSystem& system) = 0;
  /// S⁻¹ x in place, by the free columns.
  virtual void solve(double* x) = 0;
};

/// Solves by a new factor every time.
class DirectSolver : public LinearSolver {
 public:
  DirectSolver(LinearSolverType type,
               const SolverContext& context,
               SchurPattern pattern,
               std::unique_ptr<SchurFactor> factor);
  LmSolve solve(const DampedProblem& problem, double* delta) override;
  LinearSolverType type() const override { return type_; }

 private:
  LinearSolverType type_;
  SchurSystem system_;
  std::unique_ptr<SchurFactor> factor_;
};

}  // namespace raylign::native
