// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What stands in for sparse_cholesky.cpp in a build without CHOLMOD.
#include "raylign/bundle/native/sparse_cholesky.h"

namespace raylign::native {

bool has_sparse_cholesky() { return false; }

SparseOrdering order_cameras(const SchurPattern&) { return {}; }

std::unique_ptr<SchurFactor> make_sparse_cholesky(const CameraBlocks&,
                                                  const SchurPattern&,
                                                  const SparseOrdering&) {
  return nullptr;  // nobody asks: missing_linear_solver
}

}  // namespace raylign::native
