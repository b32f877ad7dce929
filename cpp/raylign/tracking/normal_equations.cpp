// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "raylign/tracking/alignment_problem.h"

namespace raylign::tracking {
namespace {

// Column k of a term's sums is column `map[k]` of [υ; ω; σ; a; b].
NormalEquations scatter(const TermSums& sums, const int* map, int columns) {
  NormalEquations equations;
  int entry = 0;
  for (int row = 0; row < columns; ++row) {
    for (int k = row; k < columns; ++k, ++entry) {
      equations.H(map[row], map[k]) = sums.H[entry];
      equations.H(map[k], map[row]) = sums.H[entry];
    }
    equations.g[map[row]] = sums.g[row];
  }
  return equations;
}

constexpr int kPhotometricColumns[] = {0, 1, 2, 3, 4, 5, kColumnA, kColumnB};
constexpr int kDepthColumns[] = {0, 1, 2, 3, 4, 5, 6};

// Entries of the 8x8 triangle: rows of a and b.
constexpr int kAa = 33;
constexpr int kAb = 34;
constexpr int kBb = 35;

}  // namespace

NormalEquations photometric_equations(const TermSums& sums, bool with_brightness) {
  return scatter(sums, kPhotometricColumns, with_brightness ? 8 : 6);
}

NormalEquations depth_equations(const TermSums& sums, bool with_scale) {
  return scatter(sums, kDepthColumns, with_scale ? 7 : 6);
}

Vector9 tile_gradient(const TileSums& tile, double depth_weight, bool with_scale) {
  Vector9 g = Vector9::Zero();
  for (int k = 0; k < 8; ++k)
    g[kPhotometricColumns[k]] = static_cast<double>(tile.g_photometric[k]);
  for (int k = 0; k < (with_scale ? 7 : 6); ++k)
    g[k] += depth_weight * static_cast<double>(tile.g_depth[k]);
  return g;
}

// With J_a = −gain I and J_b = −1 the sums hold Σw, Σw gain I, Σw (gain I)², Σw r, Σw r gain I, and
// the keyframe's intensity is r + gain I + b.
PoseState closed_form_brightness(const TermSums& sums, const PoseState& state) {
  const double w = sums.H[kBb];
  if (!(w > 0.0)) return state;
  const double mean_t = sums.H[kAb] / w;
  const double mean_r = -sums.g[7] / w;
  const double var_t = sums.H[kAa] / w - mean_t * mean_t;
  const double cov_rt = -sums.g[6] / w - mean_r * mean_t;
  const double var_r = sums.weighted_square / w - mean_r * mean_r;
  const double var_h = var_r + 2.0 * cov_rt + var_t;
  if (!(var_t > 0.0) || !(var_h > 0.0)) return state;
  const double ratio = std::sqrt(var_h / var_t);
  PoseState better = state;
  better.a = state.a + std::log(ratio);
  better.b = mean_r + mean_t + state.b - ratio * mean_t;
  return better;
}

}  // namespace raylign::tracking
