// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

/// The loops over pixel rows: plain C over raw arrays, compiled for several instruction sets
/// (base/clones.h). Inputs and outputs never overlap. Compiled without fused multiply-add: every
/// instruction set gives the same bits.
namespace raylign::image_kernels {

/// What a row of colour pixels is multiplied by, in the order of its channels.
struct GreyWeights {
  float channel[3];
};

void widen(const std::uint8_t* in, std::int64_t n, float* out);
/// out = in / 257: 65535 becomes 255.
void widen(const std::uint16_t* in, std::int64_t n, float* out);

/// n interleaved three-channel pixels; the scale as in widen, none for float.
void to_grey(const std::uint8_t* in, std::int64_t n, const GreyWeights& weights, float* out);
void to_grey(const std::uint16_t* in, std::int64_t n, const GreyWeights& weights, float* out);
void to_grey(const float* in, std::int64_t n, const GreyWeights& weights, float* out);

/// n means of 2x2 pixels.
void halve(const float* top, const float* bottom, std::int64_t n, float* out);

/// The interior of a row of GradientCells, n of them: out[4 i] = (I, I_u, I_v, 0) of pixel i;
/// I_u = (here[i + 1] - here[i - 1]) / 2 and I_v = scale_v (below[i] - above[i]).
void gradient_cells(const float* above,
                    const float* here,
                    const float* below,
                    float scale_v,
                    std::int64_t n,
                    float* out);

/// out[i] = |grad|^2 of n cells, 0 where that is not finite.
void squared_gradient(const float* cells, std::int64_t n, float* out);
void maximum(const float* a, const float* b, const float* c, std::int64_t n, float* out);
void square_root(const float* in, std::int64_t n, float* out);

/// Copies n pixels of inverse depth and variance; those without depth become (0, 0).
void mark_depth(const float* D, const float* V, std::int64_t n, float* D_out, float* V_out);

/// Two marked rows of depth.
struct DepthRows {
  const float* D[2];
  const float* V[2];
};

/// n parents of 2x2 marked pixels; see DepthPyramid.
void halve_depth(
    const DepthRows& in, float max_depth_ratio, std::int64_t n, float* D_out, float* V_out);

/// Lanes that bspline_filter filters side by side.
inline constexpr int kFilterLanes = 16;

/// In place: samples to coefficients of the cubic B-spline through them, mirrored at both ends;
/// kFilterLanes signals of n samples, sample k of lane i at data[k stride + i].
void bspline_filter(float* data, std::int64_t n, std::int64_t stride);

}  // namespace raylign::image_kernels
