// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "raylign/bundle/native/conjugate_gradients.h"
#include "raylign/bundle/native/linear_solver.h"
#include "raylign/bundle/native/make_solver.h"
#include "raylign/bundle/native/solver_costs.h"

namespace raylign::native {

/// The cheapest method by predict_costs, asked again after each step with the number of iterations
/// that conjugate gradients really take: a direct method takes over when they are too many. Memory
/// is taken when a method is chosen.
class AutoSolver : public LinearSolver {
 public:
  AutoSolver(const LinearSolverOptions& options,
             const SolverContext& context,
             InterruptCheck interrupted);
  LmSolve solve(const DampedProblem& problem, double* delta) override;
  LinearSolverType type() const override { return solver_->type(); }
  std::string reason() const override { return reason_; }

 private:
  void count();
  void choose(SolveMethod method);
  void reconsider(int iterations);

  LinearSolverOptions options_;
  SolverContext context_;
  InterruptCheck interrupted_;
  SolveCounts counts_;
  SchurStructure structure_;
  SolveMethod method_ = SolveMethod::DENSE;
  int num_steps_ = 0;
  double mean_iterations_ = SolveCounts().cg_iterations;
  std::unique_ptr<LinearSolver> solver_;
  std::string reason_;
};

}  // namespace raylign::native
