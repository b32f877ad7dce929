// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/schur_pattern.h"

namespace raylign::native {

/// Whether the library was built with CHOLMOD (CMake option RAYLIGN_USE_CHOLMOD), whose orderings a
/// sparse factor needs.
bool has_sparse_cholesky();

/// A fill-reducing order of the cameras and what a factor in it costs.
struct SparseOrdering {
  std::vector<std::int32_t> cameras;  ///< moving cameras in the order of elimination, postordered
  const char* method = "none";        ///< "amd" or "metis"
  double flops = 0.0;                 ///< of one factorisation, nine columns per camera
  double nonzeros = 0.0;              ///< of the factor
};

/// The cheaper one of approximate minimum degree and nested dissection on the graph of cameras: a
/// node is a camera, so the graph has 1/81 of the edges of the matrix.
SparseOrdering order_cameras(const SchurPattern& pattern);

}  // namespace raylign::native
