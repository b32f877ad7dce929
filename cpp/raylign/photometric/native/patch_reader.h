// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/clones.h"
#include "raylign/photometric/native/patch_kernels.h"

/// Reading the pixels of one patch, four at a time. Included by patch_kernels.cpp alone: what
/// stands here becomes part of its clones.
namespace raylign::native {

using F4 = float __attribute__((vector_size(16)));
using I4 = std::int32_t __attribute__((vector_size(16)));

/// Strips of four pixels that a pattern needs at most.
inline constexpr int kMaxStrips = 8;

RAYLIGN_INLINE F4 load(const float* p) {
  F4 v;
  __builtin_memcpy(&v, p, sizeof(v));
  return v;
}

/// Values and slopes of up to 32 pixels.
struct PatchPixels {
  F4 I[kMaxStrips];
  F4 I_u[kMaxStrips];  ///< per px of the level
  F4 I_v[kMaxStrips];
};

// bspline_weights of image/bspline.h on lanes.
template <typename V>
RAYLIGN_INLINE void spline_weights(V f, V* w, V* d) {
  const V g = 1.0f - f;
  w[0] = g * g * g * (1.0f / 6.0f);
  w[1] = 2.0f / 3.0f - f * f * (1.0f - 0.5f * f);
  w[2] = 2.0f / 3.0f - g * g * (1.0f - 0.5f * g);
  w[3] = f * f * f * (1.0f / 6.0f);
  d[0] = -0.5f * g * g;
  d[1] = f * (1.5f * f - 2.0f);
  d[2] = -g * (1.5f * g - 2.0f);
  d[3] = 0.5f * f * f;
}

/// A 4x4 patch at offsets −2..1 whose pixels share the fraction (x, y); lanes run along u. `c`: the
/// coefficient at the upper left of the 7x7 that are read.
template <bool kGradient>
RAYLIGN_INLINE void read_square_bspline(
    const float* c, std::ptrdiff_t stride, float x, float y, PatchPixels& out) {
  float wu[4], du[4], wv[4], dv[4];
  spline_weights(x, wu, du);
  spline_weights(y, wv, dv);
  F4 value[7], slope[7];
  for (int row = 0; row < 7; ++row, c += stride) {
    const F4 c0 = load(c);
    const F4 c1 = load(c + 1);
    const F4 c2 = load(c + 2);
    const F4 c3 = load(c + 3);
    value[row] = wu[0] * c0 + wu[1] * c1 + wu[2] * c2 + wu[3] * c3;
    if (kGradient) slope[row] = du[0] * c0 + du[1] * c1 + du[2] * c2 + du[3] * c3;
  }
  for (int s = 0; s < 4; ++s) {
    out.I[s] =
        wv[0] * value[s] + wv[1] * value[s + 1] + wv[2] * value[s + 2] + wv[3] * value[s + 3];
    if (!kGradient) continue;
    out.I_u[s] =
        wv[0] * slope[s] + wv[1] * slope[s + 1] + wv[2] * slope[s + 2] + wv[3] * slope[s + 3];
    out.I_v[s] =
        dv[0] * value[s] + dv[1] * value[s + 1] + dv[2] * value[s + 2] + dv[3] * value[s + 3];
  }
}

/// The same, bilinear: `c` is the pixel at the upper left of 5x5.
template <bool kGradient>
RAYLIGN_INLINE void read_square_bilinear(
    const float* c, std::ptrdiff_t stride, float x, float y, PatchPixels& out) {
  F4 value[5], slope[5];
  for (int row = 0; row < 5; ++row, c += stride) {
    const F4 c0 = load(c);
    slope[row] = load(c + 1) - c0;
    value[row] = c0 + x * slope[row];
  }
  for (int s = 0; s < 4; ++s) {
    const F4 step = value[s + 1] - value[s];
    out.I[s] = value[s] + y * step;
    if (!kGradient) continue;
    out.I_u[s] = slope[s] + y * (slope[s + 1] - slope[s]);
    out.I_v[s] = step;
  }
}

RAYLIGN_INLINE void transpose(F4& a, F4& b, F4& c, F4& d) {
  const F4 ac_low = __builtin_shufflevector(a, c, 0, 4, 1, 5);
  const F4 ac_high = __builtin_shufflevector(a, c, 2, 6, 3, 7);
  const F4 bd_low = __builtin_shufflevector(b, d, 0, 4, 1, 5);
  const F4 bd_high = __builtin_shufflevector(b, d, 2, 6, 3, 7);
  a = __builtin_shufflevector(ac_low, bd_low, 0, 4, 1, 5);
  b = __builtin_shufflevector(ac_low, bd_low, 2, 6, 3, 7);
  c = __builtin_shufflevector(ac_high, bd_high, 0, 4, 1, 5);
  d = __builtin_shufflevector(ac_high, bd_high, 2, 6, 3, 7);
}

/// Lane sums of four vectors.
RAYLIGN_INLINE F4 sum_lanes(F4 a, F4 b, F4 c, F4 d) {
  transpose(a, b, c, d);
  return (a + b) + (c + d);
}

/// Four pixels of a plane, each with its own cell (its first tap) and fraction.
struct PixelCells {
  const float* first[4];
  F4 x, y;
  std::ptrdiff_t left[4], up[4];  ///< to the cells of a central difference; 0 at the border
};

template <bool kGradient>
RAYLIGN_INLINE void read_bspline(
    const PixelCells& cells, std::ptrdiff_t stride, F4& I, F4& I_u, F4& I_v) {
  F4 wu[4], du[4], wv[4], dv[4];
  spline_weights(cells.x, wu, du);
  spline_weights(cells.y, wv, dv);
  F4 value[4], slope[4];  // of pixel k, its four columns
  for (int k = 0; k < 4; ++k) {
    const float* c = cells.first[k];
    const F4 c0 = load(c);
    const F4 c1 = load(c + stride);
    const F4 c2 = load(c + 2 * stride);
    const F4 c3 = load(c + 3 * stride);
    value[k] = wv[0][k] * c0 + wv[1][k] * c1 + wv[2][k] * c2 + wv[3][k] * c3;
    if (kGradient) slope[k] = dv[0][k] * c0 + dv[1][k] * c1 + dv[2][k] * c2 + dv[3][k] * c3;
  }
  transpose(value[0], value[1], value[2], value[3]);
  I = wu[0] * value[0] + wu[1] * value[1] + wu[2] * value[2] + wu[3] * value[3];
  if (!kGradient) return;
  transpose(slope[0], slope[1], slope[2], slope[3]);
  I_u = du[0] * value[0] + du[1] * value[1] + du[2] * value[2] + du[3] * value[3];
  I_v = wu[0] * slope[0] + wu[1] * slope[1] + wu[2] * slope[2] + wu[3] * slope[3];
}

template <bool kGradient>
RAYLIGN_INLINE void read_bilinear(
    const PixelCells& cells, std::ptrdiff_t stride, F4& I, F4& I_u, F4& I_v) {
  F4 c00, c10, c01, c11;
  for (int k = 0; k < 4; ++k) {
    const float* c = cells.first[k];
    c00[k] = c[0];
    c10[k] = c[1];
    c01[k] = c[stride];
    c11[k] = c[stride + 1];
  }
  const F4 top = c00 + cells.x * (c10 - c00);
  const F4 bottom = c01 + cells.x * (c11 - c01);
  I = top + cells.y * (bottom - top);
  if (!kGradient) return;
  I_u = (c10 - c00) + cells.y * ((c11 - c01) - (c10 - c00));
  I_v = bottom - top;
}

/// Bilinear value and half the difference of the bilinear values one pixel to either side: not the
/// derivative of the value, but what the original exercise takes for it. In the first column (row)
/// it reads the pixel's own cell for the one before.
template <bool kGradient>
RAYLIGN_INLINE void read_central_difference(
    const PixelCells& cells, std::ptrdiff_t stride, F4& I, F4& I_u, F4& I_v) {
  F4 unused_u, unused_v;
  read_bilinear<false>(cells, stride, I, unused_u, unused_v);
  if (!kGradient) return;
  F4 around[4];
  for (int n = 0; n < 4; ++n) {
    PixelCells moved = cells;
    for (int k = 0; k < 4; ++k) {
      const std::ptrdiff_t steps[4] = {1, cells.left[k], stride, cells.up[k]};
      moved.first[k] += steps[n];
    }
    read_bilinear<false>(moved, stride, around[n], unused_u, unused_v);
  }
  I_u = 0.5f * (around[0] - around[1]);
  I_v = 0.5f * (around[2] - around[3]);
}

}  // namespace raylign::native
