// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/schur_pattern.h"

namespace raylign::native {

/// Cameras that are eliminated together, by their positions in the order: a dense piece of the
/// factor of S.
struct Supernode {
  std::int32_t first, end;         ///< pivots [first, end)
  std::int32_t parent = -1;        ///< supernode that its rows go to; −1: none
  std::vector<std::int32_t> rows;  ///< beyond the pivots, ascending
  double flops = 0.0;              ///< of its elimination, nine columns per camera
};

/// The tree of supernodes, children before parents, and which parts
/// of it know nothing of each other.
struct SupernodeTree {
  /// @param order  the moving cameras in the order of elimination, postordered (order_cameras)
  SupernodeTree(const SchurPattern& pattern, const std::vector<std::int32_t>& order);

  struct Range {
    std::int32_t begin, end;
  };

  std::vector<Supernode> nodes;
  /// Whole subtrees, independent of each other, the longest work first. The cut depends on the
  /// pattern alone.
  std::vector<Range> subtrees;
  std::vector<std::int32_t> top;  ///< the other nodes, children before parents

 private:
  void find_nodes(const std::vector<std::vector<std::int32_t>>& rows);
  void find_parents();
  void cut_subtrees();
};

}  // namespace raylign::native
