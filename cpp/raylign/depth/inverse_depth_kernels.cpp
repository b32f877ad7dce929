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

RAYLIGN_INLINE float low_of(float D) { return D > 0.0F ? D : kInfinity; }

RAYLIGN_INLINE float variance(float D, const DepthNoiseLaw<float>& law) {
  const float sigma = law.sigma(D);
  return D > 0.0F ? sigma * sigma : 0.0F;
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

RAYLIGN_CLONES void variance_row(const float* D,
                                 int width,
                                 const DepthNoiseLaw<float>& law,
                                 float* V) {
  const DepthNoiseLaw<float> l = law;
  for (int u = 0; u < width; ++u) V[u] = variance(D[u], l);
}

RAYLIGN_CLONES void extremes_row(const float* D, int width, float* low, float* high) {
#pragma GCC ivdep
  for (int u = 1; u < width - 1; ++u) {
    low[u] = lower(low_of(D[u]), lower(low_of(D[u - 1]), low_of(D[u + 1])));
    high[u] = higher(D[u], higher(D[u - 1], D[u + 1]));
  }
  const int last = width - 1;
  low[0] = width > 1 ? lower(low_of(D[0]), low_of(D[1])) : low_of(D[0]);
  high[0] = width > 1 ? higher(D[0], D[1]) : D[0];
  if (width == 1) return;
  low[last] = lower(low_of(D[last]), low_of(D[last - 1]));
  high[last] = higher(D[last], D[last - 1]);
}

RAYLIGN_CLONES void wide_extremes_row(const float* D, int width, float* low, float* high) {
#pragma GCC ivdep
  for (int u = 2; u < width - 2; ++u) {
    low[u] = lower(lower(low_of(D[u]), lower(low_of(D[u - 1]), low_of(D[u + 1]))),
                   lower(low_of(D[u - 2]), low_of(D[u + 2])));
    high[u] = higher(higher(D[u], higher(D[u - 1], D[u + 1])), higher(D[u - 2], D[u + 2]));
  }
  for (int u = 0; u < width; u += u == 1 && width > 4 ? width - 3 : 1) {
    low[u] = low_of(D[u]);
    high[u] = D[u];
    for (int k = u < 2 ? 0 : u - 2; k < width && k <= u + 2; ++k) {
      low[u] = lower(low[u], low_of(D[k]));
      high[u] = higher(high[u], D[k]);
    }
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

RAYLIGN_CLONES void min3_rows(const Rows& rows, int width, float* out) {
  const Rows r = rows;
  for (int u = 0; u < width; ++u) out[u] = lower(r.above[u], lower(r.here[u], r.below[u]));
}

RAYLIGN_CLONES void max3_rows(const Rows& rows, int width, float* out) {
  const Rows r = rows;
  for (int u = 0; u < width; ++u) out[u] = higher(r.above[u], higher(r.here[u], r.below[u]));
}

RAYLIGN_CLONES void finish_row(const FiveRows& low,
                               const FiveRows& high,
                               int width,
                               float ratio,
                               const DepthNoiseLaw<float>& law,
                               float* D,
                               float* V) {
  const FiveRows l = low;
  const FiveRows h = high;
  const DepthNoiseLaw<float> noise = law;
#pragma GCC ivdep
  for (int u = 0; u < width; ++u) {
    const float lowest =
        lower(lower(l.above[u], lower(l.here[u], l.below[u])), lower(l.above2[u], l.below2[u]));
    const float highest =
        higher(higher(h.above[u], higher(h.here[u], h.below[u])), higher(h.above2[u], h.below2[u]));
    const float kept = highest - lowest > ratio * D[u] ? 0.0F : D[u];
    D[u] = kept;
    V[u] = variance(kept, noise);
  }
}

}  // namespace raylign::depth_kernels
