// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/auto_solver.h"

#include <algorithm>
#include <utility>

namespace raylign::native {
namespace {

// A change costs the memory and the analysis of the new method.
constexpr double kHysteresis = 1.5;
// Past this a graph of cameras has no order that saves anything, and finding one takes long.
constexpr double kMaxDensityToOrder = 0.5;
// Iterations on an S that is formed cost a hundredth of forming it: a step may as well be good.
constexpr double kForcingOfFormedS = 1e-3;

}  // namespace

AutoSolver::AutoSolver(const LinearSolverOptions& options,
                       const SolverContext& context,
                       InterruptCheck interrupted)
    : options_(options),
      context_(context),
      interrupted_(std::move(interrupted)),
      structure_{{context.layout, moving_cameras(context.cameras), context.pool}, {}} {
  count();
  const SolveCosts costs = predict_costs(counts_);
  choose(cheapest(costs));
  reason_ = "auto: " + std::to_string(context.layout.num_cameras) + " cameras, " +
            explain(method_, costs);
}

void AutoSolver::count() {
  const SchurPattern& pattern = structure_.pattern;
  counts_.observations = static_cast<double>(context_.layout.num_observations());
  counts_.columns = context_.cameras.num_columns();
  counts_.pairs = static_cast<double>(pattern.num_pairs);
  counts_.blocks = static_cast<double>(pattern.num_blocks());
  const double cameras = pattern.num_cameras();
  if (2.0 * counts_.blocks > kMaxDensityToOrder * cameras * cameras) return;
  structure_.ordering = order_cameras(pattern);
  counts_.sparse_flops = structure_.ordering.flops;
  counts_.sparse_nonzeros = structure_.ordering.nonzeros;
}

void AutoSolver::choose(SolveMethod method) {
  method_ = method;
  LinearSolverOptions options = options_;
  options.explicit_schur = method == SolveMethod::EXPLICIT_CG;
  if (options.explicit_schur) {
    options.forcing_tolerance = std::min(options.forcing_tolerance, kForcingOfFormedS);
  }
  const bool iterative = options.explicit_schur || method == SolveMethod::MATRIX_FREE_CG;
  options.type = iterative                       ? LinearSolverType::ITERATIVE_SCHUR
                 : method == SolveMethod::SPARSE ? LinearSolverType::SPARSE_SCHUR
                                                 : LinearSolverType::DENSE_SCHUR;
  const bool needs_S = options.preconditioner == Preconditioner::TWO_LEVEL ||
                       options.preconditioner == Preconditioner::STALE_FACTOR;
  if (needs_S && !options.explicit_schur) options.preconditioner = Preconditioner::AUTO;
  solver_.reset();  // before the next one takes memory
  solver_ = make_requested_solver(options, context_, interrupted_, &structure_);
}

void AutoSolver::reconsider(int iterations) {
  if (solver_->type() != LinearSolverType::ITERATIVE_SCHUR) return;
  ++num_steps_;
  mean_iterations_ += 0.5 * (iterations - mean_iterations_);
  // the first steps are loose: what they save is no reason to change
  counts_.cg_iterations = std::max(SolveCounts().cg_iterations, mean_iterations_);
  const SolveCosts costs = predict_costs(counts_);
  const SolveMethod best = cheapest(costs);
  if (kHysteresis * costs[static_cast<int>(best)] >= costs[static_cast<int>(method_)]) return;
  choose(best);
  reason_ += "; from step " + std::to_string(num_steps_ + 1) + " on, after " +
             std::to_string(iterations) + " iterations, " + explain(best, costs);
}

LmSolve AutoSolver::solve(const DampedProblem& problem, double* delta) {
  const LmSolve step = solver_->solve(problem, delta);
  if (step.solved && !problem.tight) reconsider(step.iterations);
  return step;
}

}  // namespace raylign::native
