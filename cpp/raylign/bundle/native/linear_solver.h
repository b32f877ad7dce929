// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/solver/lm.h"

namespace raylign::native {

/// Solves the reduced camera system that was formed last.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// Writes δ (num_columns(),) in the user's tangent. Not solved: S is not positive definite.
  virtual LmSolve solve(double* delta) = 0;
};

}  // namespace raylign::native
