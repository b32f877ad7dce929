// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_graph.h"

#include <limits>
#include <new>

namespace raylign::native {

CameraGraph::CameraGraph(const SchurPattern& pattern) {
  std::vector<std::int32_t> nodes(pattern.num_cameras(), -1);
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    if (pattern.active[i] == 0) continue;
    nodes[i] = num_nodes();
    cameras.push_back(i);
  }
  const std::int64_t num_entries = 2 * pattern.num_blocks() - num_nodes();
  if (num_entries > std::numeric_limits<std::int32_t>::max()) throw std::bad_alloc();
  const auto for_each_block = [&](const auto& visit) {
    for (const std::int32_t i : cameras) {
      for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
        visit(nodes[i], nodes[pattern.columns[b]]);
      }
    }
  };
  starts.assign(num_nodes() + 1, 0);
  for_each_block([&](std::int32_t a, std::int32_t b) {
    ++starts[a + 1];
    if (a != b) ++starts[b + 1];
  });
  for (std::int32_t n = 0; n < num_nodes(); ++n) starts[n + 1] += starts[n];
  neighbours.resize(num_entries);
  std::vector<std::int32_t> next(starts.begin(), starts.end() - 1);
  // a <= b: a node has its smaller neighbours before its own row is visited
  for_each_block([&](std::int32_t a, std::int32_t b) {
    neighbours[next[a]++] = b;
    if (a != b) neighbours[next[b]++] = a;
  });
}

}  // namespace raylign::native
