// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "raylign/bundle/native/conjugate_gradients.h"
#include "raylign/bundle/native/linear_solver.h"
#include "raylign/bundle/native/schur_system.h"

namespace raylign::native {

/// Throws OptionsError for what the native engine does not have, naming the way out.
void check_linear_solver(const LinearSolverOptions& options);

struct ChosenSolver {
  std::unique_ptr<LinearSolver> solver;
  std::string reason;  ///< Summary::linear_solver_reason
};

/// The solver that the options name, or the cheapest one by `predict_costs` for AUTO.
ChosenSolver make_linear_solver(const LinearSolverOptions& options,
                                const SolverContext& context,
                                const InterruptCheck& interrupted);

}  // namespace raylign::native
