// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/camera_graph.h"

namespace raylign::native {

/// What an order of elimination costs, known before a factor is made (Liu 1990).
struct EliminationTree {
  /// @param order  (N,) the nodes of the graph in the order of elimination
  EliminationTree(const CameraGraph& graph, const std::vector<std::int32_t>& order);

  std::vector<std::int32_t> parents;  ///< by position in the order; −1: none
  std::vector<std::int32_t> counts;   ///< rows of the factor in a column, the diagonal included

  /// Positions such that every subtree is a range that ends with its root, of siblings the one with
  /// the most rows last. The factor has the same entries in that order.
  std::vector<std::int32_t> postorder() const;
};

}  // namespace raylign::native
