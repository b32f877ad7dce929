// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/linear_solver.h"
#include "raylign/bundle/native/schur_system.h"

namespace raylign::native {

/// S as one dense matrix over the free columns, factored by LAPACK. All memory is taken at
/// construction.
class DenseCholesky : public LinearSolver {
 public:
  explicit DenseCholesky(const SchurSystem& system);
  LmSolve solve(double* delta) override;

 private:
  void fill();

  const SchurSystem& system_;
  const CameraBlocks& cameras_;
  std::vector<double> matrix_;  // lower triangle, column-major
};

}  // namespace raylign::native
