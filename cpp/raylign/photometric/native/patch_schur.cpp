// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_schur.h"

#include <cmath>

#include "raylign/base/clones.h"
#include "raylign/base/double_lanes.h"

namespace raylign::native {
namespace {

// Rows of Z = L⁻¹ W of one slot.
template <int C>
RAYLIGN_INLINE void eliminate_slot(const PointFactor& f, const double* W, int size, double* Z) {
  const double* v = f.values;
  for (int k = 0; k < C; ++k) Z[k] = v[0] * W[k];
  if (size == 1) return;
  for (int k = 0; k < C; ++k) {
    Z[C + k] = v[1] * W[k] + v[2] * W[C + k];
    Z[2 * C + k] = v[3] * W[k] + v[4] * W[C + k] + v[5] * W[2 * C + k];
  }
}

template <int C, int D>
RAYLIGN_INLINE void subtract_product(const double* Z_i, const double* Z_k, double* block) {
  for (int k = 0; k < C; k += 4) {
    D4 z[D];
    for (int d = 0; d < D; ++d) load(Z_k + d * C + k, z[d]);
    for (int r = 0; r < C; ++r) {
      D4 sum;
      load(block + r * C + k, sum);
      for (int d = 0; d < D; ++d) sum -= Z_i[d * C + r] * z[d];
      store(sum, block + r * C + k);
    }
  }
}

template <int C, int D>
RAYLIGN_INLINE void eliminate(
    const SchurArrays& a, std::int64_t begin, std::int64_t end, double* S, double* rhs) {
  constexpr std::int64_t kTile = 32;  // slots whose Z are at hand together
  double Z_row[kTile * D * C];
  double Z_column[D * C];
  for (std::int64_t p = begin; p < end; ++p) {
    const PointFactor& f = a.factors[p];
    if (f.values[0] == 0.0) continue;
    const double* g = a.points[p].g;
    double y[3] = {f.values[0] * g[0], 0.0, 0.0};
    if (D == 3) {
      y[1] = f.values[1] * g[0] + f.values[2] * g[1];
      y[2] = f.values[3] * g[0] + f.values[4] * g[1] + f.values[5] * g[2];
    }
    const std::int64_t last = a.slot_starts[p + 1];
    for (std::int64_t tile = a.slot_starts[p]; tile < last; tile += kTile) {
      const std::int64_t tile_end = tile + kTile < last ? tile + kTile : last;
      for (std::int64_t s = tile; s < tile_end; ++s) {
        double* Z = Z_row + (s - tile) * D * C;
        eliminate_slot<C>(f, a.W + s * 3 * C, D, Z);
        double* b = rhs + std::int64_t{a.slot_images[s]} * C;
        for (int k = 0; k < C; ++k) {
          for (int d = 0; d < D; ++d) b[k] += Z[d * C + k] * y[d];
        }
      }
      for (std::int64_t t = tile; t < last; ++t) {
        const double* Z_t = Z_column;
        if (t < tile_end) {
          Z_t = Z_row + (t - tile) * D * C;
        } else {
          eliminate_slot<C>(f, a.W + t * 3 * C, D, Z_column);
        }
        const std::int64_t stop = t < tile_end ? t + 1 : tile_end;
        for (std::int64_t s = tile; s < stop; ++s) {
          const std::int64_t i = a.slot_images[s];
          double* block = S + (a.block_starts[i] + a.slot_images[t] - i) * C * C;
          subtract_product<C, D>(Z_row + (s - tile) * D * C, Z_t, block);
        }
      }
    }
  }
}

template <int C>
RAYLIGN_INLINE PointStep step(const SchurArrays& a,
                              const double* images,
                              const double* X,
                              std::int64_t begin,
                              std::int64_t end,
                              double* X_trial) {
  PointStep sums;
  for (std::int64_t p = begin; p < end; ++p) {
    double w[3] = {0.0, 0.0, 0.0};
    for (std::int64_t s = a.slot_starts[p]; s < a.slot_starts[p + 1]; ++s) {
      const double* W = a.W + s * 3 * C;
      const double* delta = images + std::int64_t{a.slot_images[s]} * C;
      for (int d = 0; d < a.point_size; ++d) {
        for (int k = 0; k < C; ++k) w[d] += W[d * C + k] * delta[k];
      }
    }
    const PointBlock& block = a.points[p];
    const double* f = a.factors[p].values;
    const double* g = block.g;
    const double* H = block.H;
    double r[3], y[3], x[3] = {0.0, 0.0, 0.0};
    for (int d = 0; d < 3; ++d) r[d] = d < a.point_size ? g[d] + w[d] : 0.0;
    y[0] = f[0] * r[0];
    x[0] = -f[0] * y[0];
    if (a.point_size == 3) {
      y[1] = f[1] * r[0] + f[2] * r[1];
      y[2] = f[3] * r[0] + f[4] * r[1] + f[5] * r[2];
      x[0] = -(f[0] * y[0] + f[1] * y[1] + f[3] * y[2]);
      x[1] = -(f[2] * y[1] + f[4] * y[2]);
      x[2] = -f[5] * y[2];
    }
    const double Hx[3] = {H[0] * x[0] + H[1] * x[1] + H[2] * x[2],
                          H[1] * x[0] + H[3] * x[1] + H[4] * x[2],
                          H[2] * x[0] + H[4] * x[1] + H[5] * x[2]};
    for (int d = 0; d < 3; ++d) {
      sums.model_decrease -= x[d] * (r[d] + 0.5 * Hx[d]);
      sums.squared_step += x[d] * x[d];
      sums.squared_state += X[3 * p + d] * X[3 * p + d];
      X_trial[3 * p + d] = X[3 * p + d] + x[d];
    }
  }
  return sums;
}

}  // namespace

void factor_points(const PointBlock* points,
                   const double* damping,
                   const unsigned char* held,
                   int point_size,
                   std::int64_t begin,
                   std::int64_t end,
                   PointFactor* factors) {
  for (std::int64_t p = begin; p < end; ++p) {
    PointFactor& f = factors[p];
    f = PointFactor{};
    if (held != nullptr && held[p] != 0) continue;
    const double* H = points[p].H;
    const double* d = damping + 3 * p;
    const double l00 = std::sqrt(H[0] + d[0]);
    if (!(l00 > 0.0)) continue;
    if (point_size == 1) {
      f.values[0] = 1.0 / l00;
      continue;
    }
    const double l10 = H[1] / l00;
    const double l20 = H[2] / l00;
    const double l11 = std::sqrt(H[3] + d[1] - l10 * l10);
    const double l21 = (H[4] - l20 * l10) / l11;
    const double l22 = std::sqrt(H[5] + d[2] - l20 * l20 - l21 * l21);
    if (!(l11 > 0.0) || !(l22 > 0.0)) continue;
    double* v = f.values;
    v[0] = 1.0 / l00;
    v[2] = 1.0 / l11;
    v[5] = 1.0 / l22;
    v[1] = -l10 * v[0] * v[2];
    v[4] = -l21 * v[2] * v[5];
    v[3] = -(l20 * v[0] + l21 * v[1]) * v[5];
  }
}

RAYLIGN_CLONES
void eliminate_points(
    const SchurArrays& arrays, std::int64_t begin, std::int64_t end, double* S, double* rhs) {
  constexpr int kWide = kImageColumnsWithIntrinsics;
  if (arrays.num_columns == kImageColumns) {
    if (arrays.point_size == 3) return eliminate<kImageColumns, 3>(arrays, begin, end, S, rhs);
    return eliminate<kImageColumns, 1>(arrays, begin, end, S, rhs);
  }
  if (arrays.point_size == 3) return eliminate<kWide, 3>(arrays, begin, end, S, rhs);
  return eliminate<kWide, 1>(arrays, begin, end, S, rhs);
}

RAYLIGN_CLONES
PointStep step_points(const SchurArrays& arrays,
                      const double* images,
                      const double* X,
                      std::int64_t begin,
                      std::int64_t end,
                      double* X_trial) {
  if (arrays.num_columns == kImageColumns) {
    return step<kImageColumns>(arrays, images, X, begin, end, X_trial);
  }
  return step<kImageColumnsWithIntrinsics>(arrays, images, X, begin, end, X_trial);
}

}  // namespace raylign::native
