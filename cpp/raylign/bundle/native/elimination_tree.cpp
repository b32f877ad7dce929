// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/elimination_tree.h"

#include <algorithm>
#include <numeric>

namespace raylign::native {
namespace {

// The neighbours of the node at position p that are eliminated before it.
template <typename Visit>
void for_each_earlier(const CameraGraph& graph,
                      const std::vector<std::int32_t>& order,
                      const std::vector<std::int32_t>& positions,
                      std::int32_t p,
                      const Visit& visit) {
  for (auto e = graph.starts[order[p]]; e < graph.starts[order[p] + 1]; ++e) {
    const std::int32_t q = positions[graph.neighbours[e]];
    if (q < p) visit(q);
  }
}

}  // namespace

EliminationTree::EliminationTree(const CameraGraph& graph, const std::vector<std::int32_t>& order)
    : parents(order.size(), -1), counts(order.size(), 1) {
  const auto count = static_cast<std::int32_t>(order.size());
  std::vector<std::int32_t> positions(count);
  for (std::int32_t p = 0; p < count; ++p) positions[order[p]] = p;
  std::vector<std::int32_t> ancestors(count, -1);  // far up the tree: paths walked are shortened
  for (std::int32_t p = 0; p < count; ++p) {
    for_each_earlier(graph, order, positions, p, [&](std::int32_t q) {
      while (q >= 0 && q != p) {
        const std::int32_t next = ancestors[q];
        ancestors[q] = p;
        if (next < 0) parents[q] = p;
        q = next;
      }
    });
  }
  // row p of the factor: the paths from its entries in the graph up to p
  std::vector<std::int32_t> seen(count, -1);
  for (std::int32_t p = 0; p < count; ++p) {
    seen[p] = p;
    for_each_earlier(graph, order, positions, p, [&](std::int32_t q) {
      for (; seen[q] != p; q = parents[q]) {
        seen[q] = p;
        ++counts[q];
      }
    });
  }
}

std::vector<std::int32_t> EliminationTree::postorder() const {
  const auto count = static_cast<std::int32_t>(parents.size());
  std::vector<std::int32_t> by_rows(count);
  std::iota(by_rows.begin(), by_rows.end(), 0);
  std::sort(by_rows.begin(), by_rows.end(), [&](std::int32_t a, std::int32_t b) {
    return counts[a] != counts[b] ? counts[a] > counts[b] : a > b;
  });
  // lists of children, the last one put in front; the children of `count` are the roots
  std::vector<std::int32_t> first(count + 1, -1);
  std::vector<std::int32_t> next(count, -1);
  for (const std::int32_t p : by_rows) {
    std::int32_t& head = first[parents[p] < 0 ? count : parents[p]];
    next[p] = head;
    head = p;
  }
  std::vector<std::int32_t> result;
  std::vector<std::int32_t> path{count};
  while (!path.empty()) {
    const std::int32_t p = path.back();
    const std::int32_t child = first[p];
    if (child < 0) {
      if (p < count) result.push_back(p);
      path.pop_back();
    } else {
      first[p] = next[child];
      path.push_back(child);
    }
  }
  return result;
}

}  // namespace raylign::native
