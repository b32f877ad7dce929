// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <vector>

#include "raylign/solver/bundle_options.h"

namespace raylign::test {

/// A way of solving the native engine's linear systems.
struct NativeSolver {
  const char* name;
  LinearSolverType type;
  Preconditioner preconditioner = Preconditioner::SCHUR_JACOBI;
  bool explicit_schur = false;

  bool is_iterative() const { return type == LinearSolverType::ITERATIVE_SCHUR; }
  BundleOptions options() const {
    BundleOptions options;
    options.backend = Backend::NATIVE;
    options.linear_solver.type = type;
    options.linear_solver.preconditioner = preconditioner;
    options.linear_solver.explicit_schur = explicit_schur;
    return options;
  }
};

inline void PrintTo(const NativeSolver& solver, std::ostream* out) { *out << solver.name; }

inline const NativeSolver kNativeSolvers[] = {
    {"auto", LinearSolverType::AUTO},
    {"dense", LinearSolverType::DENSE_SCHUR},
    {"sparse", LinearSolverType::SPARSE_SCHUR},
    {"jacobi", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::JACOBI},
    {"matrix_free", LinearSolverType::ITERATIVE_SCHUR},
    {"explicit", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::SCHUR_JACOBI, true},
    {"two_level", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::TWO_LEVEL, true},
    {"stale_factor", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::STALE_FACTOR, true},
};

}  // namespace raylign::test
