// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "raylign/bundle/native/product_kernels.h"
#include "raylign/solver/lm.h"
#include "raylign/solver/options.h"

namespace raylign::native {

/// Forms the reduced camera system of a damped problem and solves it.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// Writes δ (num_columns(),) in the user's tangent. Not solved: S is not positive definite.
  virtual LmSolve solve(const DampedProblem& problem, double* delta) = 0;
  virtual LinearSolverType type() const = 0;
  /// Summary::linear_solver_reason.
  virtual std::string reason() const { return "requested"; }
};

}  // namespace raylign::native
