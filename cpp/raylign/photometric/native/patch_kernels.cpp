// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_kernels.h"

#include "raylign/photometric/native/patch_assembly.h"

namespace raylign::native {
namespace {

// Walks points [begin, end), the next one projected while one is worked on; calls visit(p, of p, of
// p + 1).
template <typename Visit>
RAYLIGN_INLINE void for_each_point(const PatchArrays& arrays,
                                   const PatchStateArrays& state,
                                   std::int64_t begin,
                                   std::int64_t end,
                                   const Visit& visit) {
  PointAhead ahead[2];
  if (begin < end) look_ahead(arrays, state, begin, ahead[0]);
  for (std::int64_t p = begin; p < end; ++p) {
    if (p + 1 < end) look_ahead(arrays, state, p + 1, ahead[(p + 1 - begin) & 1]);
    visit(p, ahead[(p - begin) & 1], ahead[(p + 1 - begin) & 1]);
  }
}

RAYLIGN_INLINE double scale_of(const KernelEdge& edge) {
  return 1.0 / static_cast<double>(std::int64_t{1} << edge.level);
}

// Edge k of the point `ahead`: its projection and pixels, or false.
template <bool kGradient>
RAYLIGN_INLINE bool see_edge(const PatchArrays& arrays,
                             const PatchStateArrays& state,
                             const PointAhead& ahead,
                             const KernelEdge& edge,
                             std::int64_t k,
                             Projection& projection,
                             PatchPixels& pixels) {
  return project_edge(arrays, state, ahead, edge, k, projection) &&
         read_patch<kGradient>(arrays, edge, projection.u, projection.v, scale_of(edge), pixels);
}

RAYLIGN_INLINE void leave(const PatchArrays& arrays,
                          const double* left_costs,
                          std::int64_t e,
                          double& twice) {
  if (left_costs != nullptr) twice += 2.0 * left_costs[e];
  if (arrays.was_out != nullptr) arrays.was_out[e] = 1;
}

template <int C>
RAYLIGN_INLINE PatchSums linearize(const PatchArrays& arrays,
                                   const PatchStateArrays& state,
                                   std::int64_t begin,
                                   std::int64_t end,
                                   const double* left_costs,
                                   double* edge_costs,
                                   const NormalArrays& out) {
  double twice = 0.0;
  std::int64_t num_seen = 0;
  LogSum logs;
  for_each_point(
      arrays, state, begin, end,
      [&](std::int64_t p, const PointAhead& ahead,
          const PointAhead& next) __attribute__((always_inline)) {
        out.points[p] = PointBlock{};
        double* W = out.W + arrays.slot_starts[p] * 3 * C;
        const std::int64_t num_slots = arrays.slot_starts[p + 1] - arrays.slot_starts[p];
        for (std::int64_t k = 0; k < num_slots * 3 * C; ++k) W[k] = 0.0;
        const float* c = arrays.patches + p * arrays.padded_pixels;
        const std::int64_t first = arrays.starts[p];
        for (std::int64_t e = first; e < arrays.starts[p + 1]; ++e) {
          const KernelEdge& edge = arrays.edges[e];
          if (p + 1 < end) prefetch_edge(arrays, p + 1, next, e - first);
          if (edge_costs != nullptr) edge_costs[e] = -1.0;
          if (!edge.is_alive) continue;
          Projection projection;
          PatchPixels pixels;
          if (!see_edge<true>(arrays, state, ahead, edge, e - first, projection, pixels)) {
            leave(arrays, left_costs, e, twice);
            continue;
          }
          ++num_seen;
          const Brightness brightness = edge_brightness(arrays, state, p, state.images[edge.image]);
          EdgeTensor tensor;
          const double slope = brightness.scale * brightness.gain * scale_of(edge);
          double cost = edge_cost<true>(arrays, edge, pixels, c, brightness, slope, logs, tensor);
          if (edge_costs != nullptr) {
            take_log(logs);
            cost += arrays.law_scale * logs.sum;
            logs.sum = 0.0;
            edge_costs[e] = 0.5 * cost;
          }
          twice += cost;
          if (arrays.was_out == nullptr || arrays.was_out[e] == 0) {
            add_edge<C>(arrays, state, out, p, edge, ahead.point, projection, brightness, tensor);
          }
          if (logs.product > kLargeProduct) take_log(logs);
        }
      });
  take_log(logs);
  return {0.5 * (twice + arrays.law_scale * logs.sum), num_seen};
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
  double twice = 0.0;
  std::int64_t num_seen = 0;
  LogSum logs;
  for_each_point(
      arrays, state, begin, end,
      [&](std::int64_t p, const PointAhead& ahead,
          const PointAhead& next) __attribute__((always_inline)) {
        const float* c = arrays.patches + p * arrays.padded_pixels;
        const std::int64_t first = arrays.starts[p];
        for (std::int64_t e = first; e < arrays.starts[p + 1]; ++e) {
          const KernelEdge& edge = arrays.edges[e];
          if (p + 1 < end) prefetch_edge(arrays, p + 1, next, e - first);
          if (!edge.is_alive) continue;
          Projection projection;
          PatchPixels pixels;
          if (!see_edge<false>(arrays, state, ahead, edge, e - first, projection, pixels)) {
            leave(arrays, left_costs, e, twice);
            continue;
          }
          ++num_seen;
          EdgeTensor unused;
          const Brightness brightness = edge_brightness(arrays, state, p, state.images[edge.image]);
          twice += edge_cost<false>(arrays, edge, pixels, c, brightness, 0.0, logs, unused);
          if (logs.product > kLargeProduct) take_log(logs);
        }
      });
  take_log(logs);
  return {0.5 * (twice + arrays.law_scale * logs.sum), num_seen};
}

}  // namespace raylign::native
