// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/iterative_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace raylign::native {
namespace {

constexpr double kMinForcing = 1e-4;
constexpr double kSafeguard = 0.1;
constexpr double kTight = 1e-3;

}  // namespace

IterativeSolver::IterativeSolver(const SolverContext& context,
                                 SchurPattern pattern,
                                 std::unique_ptr<SchurProduct> product,
                                 std::unique_ptr<SchurPreconditioner> preconditioner,
                                 const LinearSolverOptions& options,
                                 InterruptCheck interrupted)
    : system_(context, std::move(pattern)),
      product_(std::move(product)),
      preconditioner_(std::move(preconditioner)),
      options_(options),
      interrupted_(std::move(interrupted)),
      cg_(system_.rhs().size()),
      x_(system_.rhs().size()),
      eta_(options.forcing_tolerance) {}

void IterativeSolver::update_forcing(int linearization, double rhs_norm) {
  if (linearization == linearization_) return;  // the same system with another damping
  const double largest = options_.forcing_tolerance;
  if (linearization_ >= 0 && rhs_norm_ > 0.0) {
    constexpr double kGamma = 0.9;
    constexpr double kGolden = 1.618033988749895;
    const double before = kGamma * std::pow(eta_, kGolden);
    eta_ = kGamma * std::pow(rhs_norm / rhs_norm_, kGolden);
    if (before > kSafeguard) eta_ = std::max(eta_, before);
    eta_ = std::clamp(eta_, std::min(kMinForcing, largest), largest);
  }
  linearization_ = linearization;
  rhs_norm_ = rhs_norm;
}

LmSolve IterativeSolver::solve(const DampedProblem& problem, double* delta) {
  system_.form(problem);
  preconditioner_->prepare(system_, problem);
  product_->prepare(system_, problem);
  const double rhs_norm = cg_.norm(*preconditioner_, system_.rhs());
  update_forcing(problem.linearization, rhs_norm);
  CgLimits limits{eta_, eta_, options_.max_num_iterations};
  if (problem.tight) limits.residual_tolerance = limits.model_tolerance = std::min(eta_, kTight);
  const CgResult result =
      cg_.solve(*product_, *preconditioner_, system_.rhs(), limits, interrupted_, x_);
  preconditioner_->report(result.iterations);
  pack(system_.cameras(), x_.data(), delta);
  LmSolve solve;
  solve.interrupted = result.interrupted;
  solve.inexact = !problem.tight;
  solve.iterations = std::max(1, result.iterations);
  solve.solved = result.solved && !result.interrupted &&
                 std::all_of(x_.begin(), x_.end(), [](double x) { return std::isfinite(x); });
  return solve;
}

}  // namespace raylign::native
