// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/schur_pattern.h"

namespace raylign::native {

/// Which moving cameras share a block of S: a node is a camera, so the graph has 1/81 of the edges
/// of the matrix. Throws std::bad_alloc past 2³¹ edges.
struct CameraGraph {
  explicit CameraGraph(const SchurPattern& pattern);

  std::vector<std::int32_t> cameras;  ///< (N,) of each node
  std::vector<std::int32_t> starts;   ///< (N + 1,) first neighbour of each node
  /// Ascending, each edge from both ends, the node itself among them: Eigen's minimum degree leaves
  /// a node without a diagonal entry for the end.
  std::vector<std::int32_t> neighbours;

  std::int32_t num_nodes() const { return static_cast<std::int32_t>(cameras.size()); }
};

}  // namespace raylign::native
