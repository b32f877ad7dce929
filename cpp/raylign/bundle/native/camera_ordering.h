// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/schur_pattern.h"

namespace raylign::native {

/// A fill-reducing order of the cameras and what a factor in it costs.
struct SparseOrdering {
  std::vector<std::int32_t> cameras;  ///< moving cameras in the order of elimination, postordered
  const char* method = "none";        ///< "amd" or "metis"
  double flops = 0.0;                 ///< of one factorisation, nine columns per camera
  double nonzeros = 0.0;              ///< of the factor
};

/// The cheaper one of minimum degree (minimum_degree.h) and, where the build has it, nested
/// dissection (nested_dissection.h) on the graph of cameras.
SparseOrdering order_cameras(const SchurPattern& pattern);

}  // namespace raylign::native
