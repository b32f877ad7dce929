// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/depth_cells.h"

#include <cmath>
#include <cstddef>

#include "raylign/base/clones.h"

namespace raylign::tracking {
namespace {

constexpr float kNoiseSpread = 18.0F;  // (3 √2)² on V
constexpr float kSlant = 0.05F;

RAYLIGN_INLINE float smaller(float a, float b) { return a < b ? a : b; }
RAYLIGN_INLINE float larger(float a, float b) { return a > b ? a : b; }

RAYLIGN_INLINE bool is_one_surface(float low, float high, float variance) {
  const float spread = high - low;
  return (spread <= kSlant * high) | (spread * spread <= kNoiseSpread * variance);
}

// Towards the neighbours before and after, of those that have depth and lie on the surface.
RAYLIGN_INLINE float slope(
    float before, float V_before, float here, float V, float after, float V_after) {
  const bool has_before =
      (V_before > 0.0F) & is_one_surface(smaller(before, here), larger(before, here), V);
  const bool has_after =
      (V_after > 0.0F) & is_one_surface(smaller(after, here), larger(after, here), V);
  const float step = (has_after ? after : here) - (has_before ? before : here);
  return has_before & has_after ? 0.5F * step : step;
}

// One row; D and V point to its first pixel, the rows above and below lie `stride` away.
RAYLIGN_INLINE void make_row(
    const float* D, const float* V, std::ptrdiff_t stride, int width, DepthCell* cells) {
#pragma GCC ivdep
  for (int u = 1; u < width - 1; ++u) {
    const float here = D[u];
    const float variance = V[u];
    const float* below = D + stride;
    const float* V_below = V + stride;
    const float du = slope(D[u - 1], V[u - 1], here, variance, D[u + 1], V[u + 1]);
    const float dv = slope(D[u - stride], V[u - stride], here, variance, below[u], V_below[u]);
    const float low = smaller(smaller(here, D[u + 1]), smaller(below[u], below[u + 1]));
    const float high = larger(larger(here, D[u + 1]), larger(below[u], below[u + 1]));
    const float mean = 0.25F * (variance + V[u + 1] + V_below[u] + V_below[u + 1]);
    const bool has_depth = variance > 0.0F;
    const bool is_quad = has_depth & (V[u + 1] > 0.0F) & (V_below[u] > 0.0F) &
                         (V_below[u + 1] > 0.0F) & is_one_surface(low, high, mean);
    cells[u].D = here;
    cells[u].du = has_depth ? du : 0.0F;
    cells[u].dv = has_depth ? dv : 0.0F;
    cells[u].variance = is_quad ? mean : -1.0F;
  }
}

}  // namespace

RAYLIGN_CLONES void make_depth_cells(
    const float* D, const float* V, int width, int height, DepthCell* cells) {
  for (int v = 0; v < height; ++v) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(v) * width;
    const bool is_inner = v > 0 && v + 1 < height;
    for (int u = 0; u < width; u += is_inner && u == 0 && width > 1 ? width - 1 : 1) {
      cells[row + u] = {D[row + u], 0.0F, 0.0F, -1.0F};
    }
    if (is_inner) make_row(D + row, V + row, width, width, cells + row);
  }
}

}  // namespace raylign::tracking
