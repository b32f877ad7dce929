// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/kernels.h"

#include "raylign/tracking/kernel_strips.h"

namespace raylign::tracking {
namespace {

RAYLIGN_INLINE void photometric_columns(const Warped& warped, int n, Residuals& out) {
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    float J[6];
    photometric_jacobian(point_of(warped, i), warped.pose, out.g_u[i], out.g_v[i], J);
    const bool ok = out.ok[i] != 0;
    for (int k = 0; k < 6; ++k) out.J[k][i] = ok ? J[k] : 0.0F;
  }
}

RAYLIGN_INLINE void brightness_columns(const float* sampled, float gain, int n, Residuals& out) {
  for (int i = 0; i < n; ++i) {
    const bool ok = out.ok[i] != 0;
    out.J[6][i] = ok ? -gain * sampled[4 * i] : 0.0F;
    out.J[7][i] = ok ? -1.0F : 0.0F;
  }
}

RAYLIGN_INLINE void depth_columns(const Warped& warped, int n, Residuals& out) {
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    float J[7];
    depth_jacobian(point_of(warped, i), warped.pose, out.g_u[i], out.g_v[i], J);
    const bool ok = out.ok[i] != 0;
    for (int k = 0; k < 7; ++k) out.J[k][i] = ok ? J[k] : 0.0F;
  }
}

// Row `Row` of JᵀWJ and of JᵀWr.
template <int Row, int Columns>
RAYLIGN_INLINE void accumulate_row(const Residuals& in, int n, Lanes*& H, Lanes* g) {
  Lanes sums[Columns - Row];
  for (int k = 0; k < Columns - Row; ++k) sums[k] = H[k];
  Lanes rhs = g[Row];
  for (int i = 0; i < n; i += kLanes) {
    const Lanes J = load(in.J[Row] + i);
    const Lanes wJ = load(in.w + i) * J;
    for (int k = 0; k < Columns - Row; ++k) sums[k] += wJ * load(in.J[Row + k] + i);
    rhs += load(in.wr + i) * J;
  }
  for (int k = 0; k < Columns - Row; ++k) H[k] = sums[k];
  g[Row] = rhs;
  H += Columns - Row;
}

template <int Columns>
RAYLIGN_INLINE void accumulate(const Residuals& in, int n, TermLanes& sums) {
  Lanes* H = sums.H;
  accumulate_row<0, Columns>(in, n, H, sums.g);
  accumulate_row<1, Columns>(in, n, H, sums.g);
  accumulate_row<2, Columns>(in, n, H, sums.g);
  accumulate_row<3, Columns>(in, n, H, sums.g);
  accumulate_row<4, Columns>(in, n, H, sums.g);
  accumulate_row<5, Columns>(in, n, H, sums.g);
  if constexpr (Columns > 6) accumulate_row<6, Columns>(in, n, H, sums.g);
  if constexpr (Columns > 7) accumulate_row<7, Columns>(in, n, H, sums.g);
}

RAYLIGN_INLINE void accumulate_costs(Residuals& in, int n, TermLanes& sums) {
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const bool ok = in.ok[i] != 0;
    in.rho[i] = ok ? in.rho[i] : 0.0F;
    in.rho_reference[i] = ok ? in.rho_reference[i] : 0.0F;
    in.n2[i] *= in.d_rho[i];
    in.n2_reference[i] = ok ? 1.0F : 0.0F;
  }
  for (int i = 0; i < n; i += kLanes) {
    sums.rho += load(in.rho + i);
    sums.rho_reference += load(in.rho_reference + i);
    sums.weight += load(in.d_rho + i);
    sums.weighted_square += load(in.n2 + i);
    sums.count += load(in.n2_reference + i);
  }
}

RAYLIGN_INLINE void flush(const TermLanes& lanes, int columns, TermSums& sums) {
  for (int k = 0; k < columns * (columns + 1) / 2; ++k) sums.H[k] += sum_lanes(lanes.H[k]);
  for (int k = 0; k < columns; ++k) sums.g[k] += sum_lanes(lanes.g[k]);
  sums.rho += sum_lanes(lanes.rho);
  sums.rho_reference += sum_lanes(lanes.rho_reference);
  sums.count += sum_lanes(lanes.count);
  sums.weight += sum_lanes(lanes.weight);
  sums.weighted_square += sum_lanes(lanes.weighted_square);
}

// Good points and usage; LSD-SLAM's tests of a track, on points instead of pixels.
RAYLIGN_INLINE void accumulate_status(
    const Warped& warped, const float* D, const Residuals& in, int n, Lanes& good, Lanes& usage) {
  alignas(32) float is_good[kStrip];
  alignas(32) float used[kStrip];
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const bool ok = in.ok[i] != 0;
    const float g2 = in.g_u[i] * in.g_u[i] + in.g_v[i] * in.g_v[i];
    const float closer = warped.inverse_z[i] / D[i];  // NaN at D = 0: a point that keeps its size
    is_good[i] = (ok & (in.r[i] * in.r[i] < kGoodConstant + kGoodGradient * g2)) ? 1.0F : 0.0F;
    used[i] = ok ? (closer < 1.0F ? closer : 1.0F) : 0.0F;
  }
  for (int i = 0; i < n; i += kLanes) {
    good += load(is_good + i);
    usage += load(used + i);
  }
}

// How many points agree, and how many would with the target taken at another point of the tile,
// half the tile away and some: what a wrong pose scores.
RAYLIGN_INLINE void accumulate_tile(const float* I,
                                    const PassSettings& settings,
                                    const float* sampled,
                                    const Residuals& in,
                                    int n,
                                    TileSums& tile) {
  const int shift = n / 2 + kPartnerShift;
  int pairs = 0;
  int agree = 0;
  int by_chance = 0;
  for (int i = 0; i < n; ++i) {
    const int partner = (i + shift) % n;
    if (in.ok[i] == 0 || in.ok[partner] == 0) continue;
    const float limit = kAgreement * in.variance[i];
    const float other = photometric_residual(I[i], sampled[4 * partner], settings.gain, settings.b);
    ++pairs;
    agree += in.r[i] * in.r[i] < limit ? 1 : 0;
    by_chance += other * other < limit ? 1 : 0;
  }
  tile.pairs += pairs;
  tile.agree += agree;
  tile.agree_by_chance += by_chance;
}

RAYLIGN_INLINE void store(const float* from, int n, float* to) {
  for (int i = 0; i < n; ++i) to[i] = from[i];
}

// From residuals and σ² of a term to its weights; σ² goes to `variances`, too.
RAYLIGN_INLINE void weigh_term(const PassSettings& settings,
                               const float* reference,
                               float scale,
                               std::int64_t first,
                               int n,
                               float* variances,
                               Residuals& residuals) {
  normalise_strip(reference == nullptr ? nullptr : reference + first, settings.freeze, scale, n,
                  residuals);
  loss_strip(*settings.loss, n, residuals);
  weigh_strip(scale, n, residuals);
  store(residuals.variance, n, variances + first);
}

}  // namespace

RAYLIGN_CLONES void evaluate(const PointArrays& points,
                             const TargetArrays& target,
                             const PassSettings& settings,
                             std::int64_t begin,
                             std::int64_t end,
                             const VarianceArrays& variances,
                             PassSums& sums,
                             TileSums* tile) {
  Warped warped;
  warped.pose = settings.pose;
  Residuals residuals;
  TermLanes photometric = {};
  TermLanes depth = {};
  Lanes good = {};
  Lanes usage = {};
  alignas(32) float sampled[4 * kStrip];
  for (std::int64_t first = begin; first < end; first += kStrip) {
    const int n = static_cast<int>(end - first < kStrip ? end - first : kStrip);
    warp_strip(points, target, first, n, warped);
    sample_strip(&target.cells->value, target.width, warped, n, sampled);
    photometric_strip(points, settings, warped, sampled, first, n, residuals);
    weigh_term(settings, settings.reference_photometric, settings.photometric_scale, first, n,
               variances.photometric, residuals);
    photometric_columns(warped, n, residuals);
    if (settings.with_brightness) {
      brightness_columns(sampled, settings.gain, n, residuals);
      accumulate<8>(residuals, n, photometric);
    } else {
      accumulate<6>(residuals, n, photometric);
    }
    accumulate_costs(residuals, n, photometric);
    accumulate_status(warped, points.D + first, residuals, n, good, usage);
    if (tile != nullptr) {
      accumulate_tile(points.I + first, settings, sampled, residuals, n, *tile);
    }
    if (target.depth == nullptr) continue;
    sample_strip(&target.depth->D, target.width, warped, n, sampled);
    depth_strip(points, target, settings, warped, sampled, first, n, residuals);
    weigh_term(settings, settings.reference_depth, settings.depth_scale, first, n, variances.depth,
               residuals);
    depth_columns(warped, n, residuals);
    if (settings.with_scale) {
      accumulate<7>(residuals, n, depth);
    } else {
      accumulate<6>(residuals, n, depth);
    }
    accumulate_costs(residuals, n, depth);
  }
  flush(photometric, settings.with_brightness ? 8 : 6, sums.photometric);
  flush(depth, settings.with_scale ? 7 : 6, sums.depth);
  sums.good += sum_lanes(good);
  sums.usage += sum_lanes(usage);
  if (tile == nullptr) return;
  tile->count += sum_lanes(photometric.count);
  for (int k = 0; k < kMaxColumns; ++k) tile->g_photometric[k] += sum_lanes(photometric.g[k]);
  for (int k = 0; k < kMaxColumns; ++k) tile->g_depth[k] += sum_lanes(depth.g[k]);
}

}  // namespace raylign::tracking
