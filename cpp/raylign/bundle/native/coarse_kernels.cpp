// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/coarse_kernels.h"

#include "raylign/bundle/native/kernel_math.h"

namespace raylign::native {
namespace {

constexpr int kModeLanes = kModeRow / 4;

// T (9, 8) = factor · Sᵀ Z.
RAYLIGN_INLINE void multiply_modes(const Block& S,
                                   const double* Z,
                                   double factor,
                                   Lanes (*T)[kModeLanes]) {
  for (int c = 0; c < 9; ++c) {
    for (int v = 0; v < kModeLanes; ++v) T[c][v] = Lanes{};
  }
  for (int r = 0; r < 9; ++r) {
    Lanes row[kModeLanes];
    for (int v = 0; v < kModeLanes; ++v) row[v] = factor * lanes(Z + r * kModeRow)[v];
    for (int c = 0; c < 9; ++c) {
      for (int v = 0; v < kModeLanes; ++v) T[c][v] += S.values[r * kRow + c] * row[v];
    }
  }
}

// out (7, 8) += Zᵀ T.
RAYLIGN_INLINE void add_projection(const double* Z, const Lanes (*T)[kModeLanes], double* out) {
  for (int m = 0; m < kModes; ++m) {
    Lanes sum[kModeLanes];
    for (int v = 0; v < kModeLanes; ++v) sum[v] = lanes(out + m * kModeRow)[v];
    for (int c = 0; c < 9; ++c) {
      for (int v = 0; v < kModeLanes; ++v) sum[v] += Z[c * kModeRow + m] * T[c][v];
    }
    for (int v = 0; v < kModeLanes; ++v) lanes(out + m * kModeRow)[v] = sum[v];
  }
}

}  // namespace

RAYLIGN_CLONES void project_row(const CoarseProjection& projection, std::int32_t i, double* panel) {
  const double* Z_i = projection.modes + std::int64_t{i} * kModeSize;
  for (auto b = projection.starts[i]; b < projection.starts[i + 1]; ++b) {
    const std::int32_t k = projection.columns[b];
    Lanes T[9][kModeLanes];
    multiply_modes(projection.blocks[b], Z_i, k == i ? 0.5 : 1.0, T);
    add_projection(projection.modes + std::int64_t{k} * kModeSize, T,
                   panel + std::int64_t{kModes} * kModeRow * projection.cluster[k]);
  }
}

}  // namespace raylign::native
