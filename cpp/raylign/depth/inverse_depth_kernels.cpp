// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/depth/inverse_depth_kernels.h"

#include "raylign/base/clones.h"

namespace raylign::depth_kernels {
namespace {

constexpr float kInfinity = __builtin_inff();
constexpr std::uint16_t kSaturated = 65535;  // what 7-Scenes writes for "no depth"

RAYLIGN_INLINE float lower(float a, float b) { return a < b ? a : b; }
RAYLIGN_INLINE float higher(float a, float b) { return a > b ? a : b; }

// NaN fails both comparisons.
RAYLIGN_INLINE float inverse_or_zero(float z, float min_depth, float max_depth) {
  return z >= min_depth && z <= max_depth ? 1.0F / z : 0.0F;
}

}  // namespace

RAYLIGN_CLONES void invert_row(
    const float* Z, int width, float min_depth, float max_depth, float* D) {
  for (int u = 0; u < width; ++u) D[u] = inverse_or_zero(Z[u], min_depth, max_depth);
}

RAYLIGN_CLONES void invert_row(const std::uint16_t* raw,
                               int width,
                               float meters_per_unit,
                               float min_depth,
                               float max_depth,
                               float* D) {
  for (int u = 0; u < width; ++u) {
    const float z = raw[u] == kSaturated ? 0.0F : static_cast<float>(raw[u]) * meters_per_unit;
    D[u] = inverse_or_zero(z, min_depth, max_depth);
  }
}

RAYLIGN_CLONES void variance_row(
    const float* D, int width, float constant, float c0, float c1, float* V) {
  for (int u = 0; u < width; ++u) {
    const float beyond = 1.0F - 0.4F * D[u];
    const float sigma = constant + c0 * D[u] * D[u] + c1 * beyond * beyond;
    V[u] = D[u] > 0.0F ? sigma * sigma : 0.0F;
  }
}

RAYLIGN_CLONES void start_extremes(const float* D, int width, float* low, float* high) {
  for (int u = 0; u < width; ++u) {
    low[u] = D[u] > 0.0F ? D[u] : kInfinity;
    high[u] = D[u];
  }
}

RAYLIGN_CLONES void min3_row(const float* in, int width, float* out) {
  for (int u = 1; u < width - 1; ++u) out[u] = lower(in[u], lower(in[u - 1], in[u + 1]));
  const int last = width - 1;
  out[0] = width > 1 ? lower(in[0], in[1]) : in[0];
  if (width > 1) out[last] = lower(in[last], in[last - 1]);
}

RAYLIGN_CLONES void max3_row(const float* in, int width, float* out) {
  for (int u = 1; u < width - 1; ++u) out[u] = higher(in[u], higher(in[u - 1], in[u + 1]));
  const int last = width - 1;
  out[0] = width > 1 ? higher(in[0], in[1]) : in[0];
  if (width > 1) out[last] = higher(in[last], in[last - 1]);
}

RAYLIGN_CLONES void min3_rows(
    const float* a, const float* b, const float* c, int width, float* out) {
  for (int u = 0; u < width; ++u) out[u] = lower(a[u], lower(b[u], c[u]));
}

RAYLIGN_CLONES void max3_rows(
    const float* a, const float* b, const float* c, int width, float* out) {
  for (int u = 0; u < width; ++u) out[u] = higher(a[u], higher(b[u], c[u]));
}

RAYLIGN_CLONES void drop_edges_row(
    const float* low, const float* high, int width, float ratio, float* D) {
  for (int u = 0; u < width; ++u) D[u] = high[u] - low[u] > ratio * D[u] ? 0.0F : D[u];
}

}  // namespace raylign::depth_kernels
