// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_kernels.h"

#include "raylign/photometric/native/patch_assembly.h"

namespace raylign::native {
namespace {

template <int C>
RAYLIGN_INLINE PatchSums linearize(const PatchArrays& arrays,
                                   const PatchStateArrays& state,
                                   std::int64_t begin,
                                   std::int64_t end,
                                   const double* left_costs,
                                   double* edge_costs,
                                   const NormalArrays& out) {
  PatchSums sums;
  for (std::int64_t p = begin; p < end; ++p) {
    out.points[p] = PointBlock{};
    double* W = out.W + arrays.slot_starts[p] * 3 * C;
    const std::int64_t num_slots = arrays.slot_starts[p + 1] - arrays.slot_starts[p];
    for (std::int64_t k = 0; k < num_slots * 3 * C; ++k) W[k] = 0.0;
    const HomogeneousPoint point = load_point(arrays, state, p);
    const float* c = arrays.patches + p * arrays.padded_pixels;
    for (std::int64_t e = arrays.starts[p]; e < arrays.starts[p + 1]; ++e) {
      const KernelEdge& edge = arrays.edges[e];
      if (edge_costs != nullptr) edge_costs[e] = -1.0;
      if (!edge.is_alive) continue;
      const ImagePacket& image = state.images[edge.image];
      const double scale = 1.0 / static_cast<double>(std::int64_t{1} << edge.level);
      Projection projection;
      PatchPixels pixels;
      if (!project(image, point, arrays.min_depth, projection) ||
          !read_patch<true>(arrays, edge, projection.u, projection.v, scale, pixels)) {
        if (left_costs != nullptr) sums.cost += left_costs[e];
        continue;
      }
      ++sums.num_seen;
      const Brightness brightness = edge_brightness(arrays, state, p, image);
      EdgeTensor tensor;
      const double cost =
          edge_cost<true>(arrays, edge, pixels, c, brightness, brightness.gain * scale, tensor);
      sums.cost += cost;
      if (edge_costs != nullptr) edge_costs[e] = cost;
      add_edge<C>(arrays, state, out, p, edge, point, projection, brightness, tensor);
    }
  }
  return sums;
}

}  // namespace

RAYLIGN_CLONES
PatchSums linearize_points(const PatchArrays& arrays,
                           const PatchStateArrays& state,
                           std::int64_t begin,
                           std::int64_t end,
                           const double* left_costs,
                           double* edge_costs,
                           const NormalArrays& out) {
  if (arrays.with_intrinsics) {
    return linearize<kImageColumnsWithIntrinsics>(arrays, state, begin, end, left_costs, edge_costs,
                                                  out);
  }
  return linearize<kImageColumns>(arrays, state, begin, end, left_costs, edge_costs, out);
}

RAYLIGN_CLONES
PatchSums evaluate_points(const PatchArrays& arrays,
                          const PatchStateArrays& state,
                          std::int64_t begin,
                          std::int64_t end,
                          const double* left_costs) {
  PatchSums sums;
  for (std::int64_t p = begin; p < end; ++p) {
    const HomogeneousPoint point = load_point(arrays, state, p);
    const float* c = arrays.patches + p * arrays.padded_pixels;
    for (std::int64_t e = arrays.starts[p]; e < arrays.starts[p + 1]; ++e) {
      const KernelEdge& edge = arrays.edges[e];
      if (!edge.is_alive) continue;
      const ImagePacket& image = state.images[edge.image];
      const double scale = 1.0 / static_cast<double>(std::int64_t{1} << edge.level);
      Projection projection;
      PatchPixels pixels;
      if (!project(image, point, arrays.min_depth, projection) ||
          !read_patch<false>(arrays, edge, projection.u, projection.v, scale, pixels)) {
        if (left_costs != nullptr) sums.cost += left_costs[e];
        continue;
      }
      ++sums.num_seen;
      EdgeTensor unused;
      const Brightness brightness = edge_brightness(arrays, state, p, image);
      sums.cost += edge_cost<false>(arrays, edge, pixels, c, brightness, 0.0, unused);
    }
  }
  return sums;
}

}  // namespace raylign::native
