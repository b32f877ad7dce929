// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/schur_factor.h"

namespace raylign::native {

/// S as one dense matrix over the free columns, factored by LAPACK. All memory is taken at
/// construction.
class DenseCholesky : public SchurFactor {
 public:
  DenseCholesky(const CameraBlocks& cameras, ThreadPool& pool);
  bool factor(const SchurSystem& system) override;
  void solve(double* x) override;

 private:
  void fill(const SchurSystem& system);

  const CameraBlocks& cameras_;
  ThreadPool& pool_;
  std::vector<double> matrix_;  // lower triangle, column-major
};

}  // namespace raylign::native
