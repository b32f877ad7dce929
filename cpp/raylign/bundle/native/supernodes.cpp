// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/supernodes.h"

#include <algorithm>

namespace raylign::native {
namespace {

constexpr double kSize = 9.0;  // columns per camera
// Two supernodes become one where few zeros are stored for it: the larger, the fewer. Small dense
// pieces cost more to call for than to compute.
constexpr std::int32_t kSmall = 4;  // cameras
constexpr double kZerosOfSmall = 0.8;
constexpr std::int32_t kMedium = 12;
constexpr double kZerosOfMedium = 0.25;
constexpr double kZerosOfLarge = 0.08;
// A subtree of less than this share of all work is one task.
constexpr double kTask = 1.0 / 10.0;

// Rows below the diagonal of the factor, column by column: what S has and what the children leave
// (Davis 2006, §4.8).
std::vector<std::vector<std::int32_t>> factor_rows(const SchurPattern& pattern,
                                                   const std::vector<std::int32_t>& order) {
  const auto count = static_cast<std::int32_t>(order.size());
  std::vector<std::int32_t> position(pattern.num_cameras(), -1);
  for (std::int32_t p = 0; p < count; ++p) position[order[p]] = p;
  std::vector<std::vector<std::int32_t>> rows(count);
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      const std::int32_t p = position[i];
      const std::int32_t q = position[pattern.columns[b]];
      if (p != q) rows[std::min(p, q)].push_back(std::max(p, q));
    }
  }
  for (std::int32_t p = 0; p < count; ++p) {
    std::sort(rows[p].begin(), rows[p].end());
    rows[p].erase(std::unique(rows[p].begin(), rows[p].end()), rows[p].end());
    if (rows[p].empty()) continue;
    auto& parent = rows[rows[p].front()];
    parent.insert(parent.end(), rows[p].begin() + 1, rows[p].end());
  }
  return rows;
}

double elimination_flops(const Supernode& node) {
  const double pivots = kSize * (node.end - node.first);
  const double rows = kSize * static_cast<double>(node.rows.size());
  return pivots * (pivots * pivots / 3.0 + pivots * rows + rows * rows);
}

// Blocks of the lower triangle and the rows.
double num_blocks(const Supernode& node) {
  const double pivots = node.end - node.first;
  return pivots * (0.5 * (pivots + 1.0) + static_cast<double>(node.rows.size()));
}

}  // namespace

SupernodeTree::SupernodeTree(const SchurPattern& pattern, const std::vector<std::int32_t>& order) {
  find_nodes(factor_rows(pattern, order));
  find_parents();
  cut_subtrees();
}

// Column after column: each joins the nodes before it as long as that is worth its zeros.
void SupernodeTree::find_nodes(const std::vector<std::vector<std::int32_t>>& rows) {
  std::vector<double> zeros;  // blocks that are stored and zero
  const auto joins_last = [&](const Supernode& node, double node_zeros) {
    if (nodes.empty()) return -1.0;
    const Supernode& last = nodes.back();
    if (last.rows.empty() || last.rows.front() >= node.end) return -1.0;  // not a child
    const double pivots = last.end - last.first;
    const double added = pivots * (node.end - node.first + static_cast<double>(node.rows.size()) -
                                   static_cast<double>(last.rows.size()));
    Supernode joint = node;
    joint.first = last.first;
    const double sum = zeros.back() + node_zeros + added;
    const std::int32_t size = joint.end - joint.first;
    const double share = size <= kSmall    ? kZerosOfSmall
                         : size <= kMedium ? kZerosOfMedium
                                           : kZerosOfLarge;
    return sum <= share * num_blocks(joint) ? sum : -1.0;
  };
  for (std::int32_t p = 0; p < static_cast<std::int32_t>(rows.size()); ++p) {
    Supernode node;
    node.first = p;
    node.end = p + 1;
    node.rows = rows[p];
    double node_zeros = 0.0;
    for (double sum = joins_last(node, 0.0); sum >= 0.0; sum = joins_last(node, node_zeros)) {
      node.first = nodes.back().first;
      node_zeros = sum;
      nodes.pop_back();
      zeros.pop_back();
    }
    nodes.push_back(std::move(node));
    zeros.push_back(node_zeros);
  }
}

void SupernodeTree::find_parents() {
  std::vector<std::int32_t> node_of;  // by position
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].flops = elimination_flops(nodes[n]);
    node_of.resize(nodes[n].end, static_cast<std::int32_t>(n));
  }
  for (Supernode& node : nodes) {
    if (!node.rows.empty()) node.parent = node_of[node.rows.front()];
  }
}

// In a postorder a subtree is a range that ends with its root.
void SupernodeTree::cut_subtrees() {
  const auto count = static_cast<std::int32_t>(nodes.size());
  std::vector<double> flops(count);
  std::vector<std::int32_t> begin(count);
  for (std::int32_t n = 0; n < count; ++n) begin[n] = n;
  double total = 0.0;
  for (std::int32_t n = 0; n < count; ++n) {
    flops[n] += nodes[n].flops;
    total += nodes[n].flops;
    const std::int32_t parent = nodes[n].parent;
    if (parent < 0) continue;
    flops[parent] += flops[n];
    begin[parent] = std::min(begin[parent], begin[n]);
  }
  for (std::int32_t n = 0; n < count; ++n) {
    const std::int32_t parent = nodes[n].parent;
    if (flops[n] > kTask * total) {
      top.push_back(n);
    } else if (parent < 0 || flops[parent] > kTask * total) {
      subtrees.push_back({begin[n], n + 1});
    }
  }
  std::stable_sort(subtrees.begin(), subtrees.end(), [&](const Range& a, const Range& b) {
    return flops[a.end - 1] > flops[b.end - 1];
  });
}

}  // namespace raylign::native
