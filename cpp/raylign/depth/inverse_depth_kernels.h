// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/depth/depth_noise_law.h"

/// The loops over pixels behind InverseDepthConverter: plain C over rows, compiled for several
/// instruction sets.
namespace raylign::depth_kernels {

/// D = 1 / Z for min_depth <= Z <= max_depth, else 0 (NaN too). Z in m.
void invert_row(const float* Z, int width, float min_depth, float max_depth, float* D);
/// The same of Z = raw · meters_per_unit; raw 0 and 65535 have no depth.
void invert_row(const std::uint16_t* raw,
                int width,
                float meters_per_unit,
                float min_depth,
                float max_depth,
                float* D);

/// V = σ²; 0 where D is 0.
void variance_row(const float* D, int width, const DepthNoiseLaw<float>& law, float* V);

/// low and high = min and max of D[u − 1 … u + 1], clipped at the ends; a D of 0 does not count.
void extremes_row(const float* D, int width, float* low, float* high);
/// The same of D[u − 2 … u + 2].
void wide_extremes_row(const float* D, int width, float* low, float* high);
/// out[u] = min/max of in[u − 1 … u + 1], clipped at the ends.
void min3_row(const float* in, int width, float* out);
void max3_row(const float* in, int width, float* out);

/// Three rows, one below the other.
struct Rows {
  const float* above;
  const float* here;
  const float* below;
};

/// out = min/max of three rows.
void min3_rows(const Rows& rows, int width, float* out);
void max3_rows(const Rows& rows, int width, float* out);
/// A row with the two above and the two below it.
struct FiveRows {
  const float* above2;
  const float* above;
  const float* here;
  const float* below;
  const float* below2;
};

/// D = 0 where the highest of five rows less the lowest exceeds ratio · D; V as variance_row.
void finish_row(const FiveRows& low,
                const FiveRows& high,
                int width,
                float ratio,
                const DepthNoiseLaw<float>& law,
                float* D,
                float* V);

}  // namespace raylign::depth_kernels
