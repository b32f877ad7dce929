// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

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

/// V = σ² with σ = constant + c0 D² + c1 (1 − 0.4 D)², which all laws of DepthModel are; 0 where D
/// is 0.
void variance_row(const float* D, int width, float constant, float c0, float c1, float* V);

/// low = D, +∞ where D is 0; high = D.
void start_extremes(const float* D, int width, float* low, float* high);
/// out[u] = min/max of in[u − 1 … u + 1], clipped at the ends.
void min3_row(const float* in, int width, float* out);
void max3_row(const float* in, int width, float* out);
/// out = min/max of three rows.
void min3_rows(const float* a, const float* b, const float* c, int width, float* out);
void max3_rows(const float* a, const float* b, const float* c, int width, float* out);
/// D = 0 where high − low > ratio · D.
void drop_edges_row(const float* low, const float* high, int width, float ratio, float* D);

}  // namespace raylign::depth_kernels
