// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_ordering.h"

#include "raylign/bundle/native/camera_graph.h"
#include "raylign/bundle/native/elimination_tree.h"
#include "raylign/bundle/native/minimum_degree.h"
#include "raylign/bundle/native/nested_dissection.h"

namespace raylign::native {
namespace {

SparseOrdering weigh(const CameraGraph& graph,
                     const char* method,
                     const std::vector<std::int32_t>& order) {
  constexpr double kSize = 9.0;  // columns per camera
  const EliminationTree tree(graph, order);
  SparseOrdering result;
  result.method = method;
  for (const double count : tree.counts) {
    result.flops += count * count * kSize * kSize * kSize;
    result.nonzeros += count * kSize * kSize;
  }
  for (const std::int32_t p : tree.postorder()) {
    result.cameras.push_back(graph.cameras[order[p]]);
  }
  return result;
}

}  // namespace

SparseOrdering order_cameras(const SchurPattern& pattern) {
  const CameraGraph graph(pattern);
  if (graph.cameras.empty()) return {};
  SparseOrdering best = weigh(graph, "amd", minimum_degree(graph));
  const auto dissected = nested_dissection(graph);
  if (dissected.empty()) return best;
  SparseOrdering other = weigh(graph, "metis", dissected);
  return other.flops < best.flops ? other : best;
}

}  // namespace raylign::native
