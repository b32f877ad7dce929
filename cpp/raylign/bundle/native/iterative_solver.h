// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "raylign/bundle/native/conjugate_gradients.h"
#include "raylign/bundle/native/linear_solver.h"

namespace raylign::native {

/// Solves inexactly by conjugate gradients. How exactly is the second choice of Eisenstat & Walker
/// 1996: η = 0.9 (‖b‖ / ‖b of the linearisation before‖)^φ, φ the golden ratio, within
/// [1e-4, forcing_tolerance]; 1e-3 once the loop wants exact steps (lm.h).
class IterativeSolver : public LinearSolver {
 public:
  IterativeSolver(const SolverContext& context,
                  SchurPattern pattern,
                  std::unique_ptr<SchurProduct> product,
                  std::unique_ptr<SchurPreconditioner> preconditioner,
                  const LinearSolverOptions& options,
                  InterruptCheck interrupted);
  LmSolve solve(const DampedProblem& problem, double* delta) override;
  LinearSolverType type() const override { return LinearSolverType::ITERATIVE_SCHUR; }

 private:
  void update_forcing(int linearization, double rhs_norm);

  SchurSystem system_;
  std::unique_ptr<SchurProduct> product_;
  std::unique_ptr<SchurPreconditioner> preconditioner_;
  LinearSolverOptions options_;
  InterruptCheck interrupted_;
  ConjugateGradients cg_;
  std::vector<double> x_;  // (C, kRow)
  double eta_;
  double rhs_norm_ = 0.0;
  int linearization_ = -1;
};

}  // namespace raylign::native
