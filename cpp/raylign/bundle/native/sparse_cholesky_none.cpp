// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What stands in for sparse_cholesky.cpp in a build without CHOLMOD.
#include "raylign/base/error.h"
#include "raylign/bundle/native/sparse_cholesky.h"

namespace raylign::native {

bool has_sparse_cholesky() { return false; }

void require_sparse_cholesky() {
  throw OptionsError(
      "LinearSolverOptions.type SPARSE_SCHUR with backend NATIVE needs a build with CHOLMOD (CMake "
      "option RAYLIGN_USE_CHOLMOD); use DENSE_SCHUR, ITERATIVE_SCHUR or backend CERES");
}

SparseOrdering order_cameras(const SchurPattern&) { return {}; }

std::unique_ptr<SchurFactor> make_sparse_cholesky(const CameraBlocks&,
                                                  const SchurPattern&,
                                                  const SparseOrdering&) {
  require_sparse_cholesky();
  return nullptr;
}

}  // namespace raylign::native
