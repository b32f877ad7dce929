// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "raylign/bundle/native/camera_ordering.h"
#include "raylign/bundle/native/conjugate_gradients.h"
#include "raylign/bundle/native/linear_solver.h"
#include "raylign/bundle/native/schur_system.h"

namespace raylign::native {

/// What the native engine does not have and Ceres has, naming the way out; empty: nothing.
std::string missing_linear_solver(const LinearSolverOptions& options);

/// Throws OptionsError for what does not go together.
void check_linear_solver(const LinearSolverOptions& options);

/// The solver that the options name; for AUTO an AutoSolver.
std::unique_ptr<LinearSolver> make_linear_solver(const LinearSolverOptions& options,
                                                 const SolverContext& context,
                                                 const InterruptCheck& interrupted);

/// What AUTO has found of S by the time it chooses; solvers made from it need not find it again.
struct SchurStructure {
  SchurPattern pattern;
  SparseOrdering ordering;  ///< empty: not looked for
};

/// The solver that the options name, which is not AUTO. `known`: or null.
std::unique_ptr<LinearSolver> make_requested_solver(const LinearSolverOptions& options,
                                                    const SolverContext& context,
                                                    const InterruptCheck& interrupted,
                                                    const SchurStructure* known = nullptr);

}  // namespace raylign::native
