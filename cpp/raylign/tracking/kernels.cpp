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
    out.J[6][i] = out.ok[i] != 0 ? -gain * sampled[i] : 0.0F;
    out.J[7][i] = -out.count[i];
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

RAYLIGN_INLINE void accumulate_costs(const Residuals& in, int n, TermLanes& sums) {
  for (int i = 0; i < n; i += kLanes) {
    sums.rho += load(in.rho + i);
    sums.rho_reference += load(in.rho_reference + i);
    sums.weight += load(in.d_rho + i);
    sums.weighted_square += load(in.d_rho + i) * load(in.n2 + i);
    sums.count += load(in.count + i);
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
    const Warped& warped, const Residuals& in, int n, Lanes& good, Lanes& usage) {
  alignas(32) float is_good[kStrip];
  alignas(32) float used[kStrip];
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float g2 = in.g_u[i] * in.g_u[i] + in.g_v[i] * in.g_v[i];
    const float closer = warped.inverse_q[i];  // Z_h / Z'
    is_good[i] = in.r[i] * in.r[i] < kGoodConstant + kGoodGradient * g2 ? in.count[i] : 0.0F;
    used[i] = in.ok[i] != 0 ? (closer < 1.0F ? closer : 1.0F) : 0.0F;
  }
  for (int i = 0; i < n; i += kLanes) {
    good += load(is_good + i);
    usage += load(used + i);
  }
}

// Of `n` points and their partners; see TileSums.
RAYLIGN_INLINE void count_pairs(const float* I,
                                const PassSettings& settings,
                                const float* sampled,
                                const Residuals& in,
                                int first,
                                int partner,
                                int n,
                                TileSums& tile) {
  const float gain = settings.gain;
  const float b = settings.b;
  int pairs = 0;
  int agree = 0;
  int by_chance = 0;
  for (int i = 0; i < n; ++i) {
    const int is_pair = in.ok[first + i] & in.ok[partner + i];
    const float r = in.r[first + i];
    const float other = photometric_residual(I[first + i], sampled[partner + i], gain, b);
    const float precision = in.precision[first + i];
    pairs += is_pair;
    agree += r * r * precision < kAgreement ? is_pair : 0;
    by_chance += other * other * precision < kAgreement ? is_pair : 0;
  }
  tile.pairs += static_cast<float>(pairs);
  tile.agree += static_cast<float>(agree);
  tile.agree_by_chance += static_cast<float>(by_chance);
}

// How many points [begin, end) of the strip, of one tile, agree, and how many would with the target
// taken at another point of the tile, half the tile away and some: what a wrong pose scores.
RAYLIGN_INLINE void accumulate_agreement(const float* I,
                                         const PassSettings& settings,
                                         const float* sampled,
                                         const Residuals& in,
                                         int begin,
                                         int end,
                                         TileSums& tile) {
  const int n = end - begin;
  const int shift = (n / 2 + kPartnerShift) % n;
  for (int i = begin; i < end; ++i) tile.count += in.count[i];
  count_pairs(I, settings, sampled, in, begin, begin + shift, n - shift, tile);
  count_pairs(I, settings, sampled, in, end - shift, begin, shift, tile);
}

template <int Columns>
RAYLIGN_INLINE void accumulate_gradient(const Residuals& in, int begin, int end, float* g) {
  for (int k = 0; k < Columns; ++k) {
    Lanes sum = {};
    for (int i = begin; i < end; i += kLanes) sum += load(in.wr + i) * load(in.J[k] + i);
    const Cell low = __builtin_shufflevector(sum, sum, 0, 1, 2, 3);
    const Cell high = __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
    const Cell four = low + high;
    g[k] += (four[0] + four[2]) + (four[1] + four[3]);
  }
}

RAYLIGN_INLINE void store(const float* from, int n, float* to) {
  for (int i = 0; i < n; ++i) to[i] = from[i];
}

// From residuals and 1/σ² of a term to its weights; 1/σ² goes to `precisions`, too.
RAYLIGN_INLINE void weigh_term(const PassSettings& settings,
                               const float* reference,
                               float scale,
                               std::int64_t first,
                               int n,
                               float* precisions,
                               Residuals& residuals) {
  normalise_strip(reference == nullptr ? nullptr : reference + first, settings.freeze, scale, n,
                  residuals);
  loss_strip(*settings.loss, n, residuals);
  weigh_strip(scale, n, residuals);
  store(residuals.precision, n, precisions + first);
}

// Everything that a pass sums up, and the buffers of a strip.
struct Pass {
  Warped warped;
  Sampled sampled;
  Residuals residuals;
  TermLanes photometric = {};
  TermLanes depth = {};
  Lanes good = {};
  Lanes usage = {};
};

// The part of a tile that lies in a strip.
struct Segment {
  int tile;
  int begin;
  int end;
  bool is_first;  // of the tile's parts
};

// Cuts the strip [first, first + n) at the tiles' borders; `tile` is the first that reaches into
// it, and afterwards the first that reaches into the next.
RAYLIGN_INLINE int cut_strip(
    const Tile* tiles, int num_tiles, std::int64_t first, int n, int& tile, Segment* segments) {
  int count = 0;
  while (tile < num_tiles && tiles[tile].begin < first + n) {
    const std::int64_t begin = tiles[tile].begin > first ? tiles[tile].begin : first;
    const std::int64_t end = tiles[tile].end < first + n ? tiles[tile].end : first + n;
    segments[count++] = {tile, static_cast<int>(begin - first), static_cast<int>(end - first),
                         begin == tiles[tile].begin};
    if (tiles[tile].end > first + n) break;
    ++tile;
  }
  return count;
}

RAYLIGN_INLINE void photometric_tiles(const float* I,
                                      const PassSettings& settings,
                                      const Pass& pass,
                                      const Segment* segments,
                                      int num_segments,
                                      TileSums* tiles) {
  for (int k = 0; k < num_segments; ++k) {
    const Segment& part = segments[k];
    TileSums& out = tiles[part.tile];
    if (part.is_first) out = TileSums{};
    if (settings.with_brightness) {
      accumulate_gradient<8>(pass.residuals, part.begin, part.end, out.g_photometric);
    } else {
      accumulate_gradient<6>(pass.residuals, part.begin, part.end, out.g_photometric);
    }
    accumulate_agreement(I, settings, pass.sampled.value, pass.residuals, part.begin, part.end,
                         out);
  }
}

RAYLIGN_INLINE void depth_tiles(const PassSettings& settings,
                                const Residuals& residuals,
                                const Segment* segments,
                                int num_segments,
                                TileSums* tiles) {
  for (int k = 0; k < num_segments; ++k) {
    const Segment& part = segments[k];
    if (settings.with_scale) {
      accumulate_gradient<7>(residuals, part.begin, part.end, tiles[part.tile].g_depth);
    } else {
      accumulate_gradient<6>(residuals, part.begin, part.end, tiles[part.tile].g_depth);
    }
  }
}

RAYLIGN_INLINE void accumulate_photometric(const PointArrays& points,
                                           const TargetArrays& target,
                                           const PassSettings& settings,
                                           std::int64_t first,
                                           int n,
                                           const PrecisionArrays& precisions,
                                           Pass& pass) {
  Residuals& residuals = pass.residuals;
  sample_strip<false>(&target.cells->value, target.width, pass.warped, n, pass.sampled);
  photometric_strip(points, settings, pass.warped, pass.sampled, first, n, residuals);
  weigh_term(settings, settings.reference_photometric, settings.photometric_scale, first, n,
             precisions.photometric, residuals);
  photometric_columns(pass.warped, n, residuals);
  if (settings.with_brightness) {
    brightness_columns(pass.sampled.value, settings.gain, n, residuals);
    accumulate<8>(residuals, n, pass.photometric);
  } else {
    accumulate<6>(residuals, n, pass.photometric);
  }
  accumulate_costs(residuals, n, pass.photometric);
  accumulate_status(pass.warped, residuals, n, pass.good, pass.usage);
}

RAYLIGN_INLINE void accumulate_depth(const PointArrays& points,
                                     const TargetArrays& target,
                                     const PassSettings& settings,
                                     std::int64_t first,
                                     int n,
                                     const PrecisionArrays& precisions,
                                     Pass& pass) {
  Residuals& residuals = pass.residuals;
  sample_strip<true>(&target.depth->D, target.width, pass.warped, n, pass.sampled);
  depth_strip(points, settings, pass.warped, pass.sampled, first, n, residuals);
  weigh_term(settings, settings.reference_depth, settings.depth_scale, first, n, precisions.depth,
             residuals);
  depth_columns(pass.warped, n, residuals);
  if (settings.with_scale) {
    accumulate<7>(residuals, n, pass.depth);
  } else {
    accumulate<6>(residuals, n, pass.depth);
  }
  accumulate_costs(residuals, n, pass.depth);
}

}  // namespace

RAYLIGN_CLONES void evaluate(const PointArrays& points,
                             const TargetArrays& target,
                             const PassSettings& settings,
                             const Tile* tiles,
                             int num_tiles,
                             const PrecisionArrays& precisions,
                             PassSums& sums,
                             TileSums* tile_sums) {
  Pass pass;
  pass.warped.pose = settings.pose;
  Segment segments[kStrip / kLanes];
  int num_segments = 0;
  int tile = 0;
  const std::int64_t end = tiles[num_tiles - 1].end;
  for (std::int64_t first = tiles[0].begin; first < end; first += kStrip) {
    const int n = static_cast<int>(end - first < kStrip ? end - first : kStrip);
    warp_strip(points, target, first, n, pass.warped);
    accumulate_photometric(points, target, settings, first, n, precisions, pass);
    if (tile_sums != nullptr) {
      num_segments = cut_strip(tiles, num_tiles, first, n, tile, segments);
      photometric_tiles(points.I + first, settings, pass, segments, num_segments, tile_sums);
    }
    if (target.depth == nullptr) continue;
    accumulate_depth(points, target, settings, first, n, precisions, pass);
    if (tile_sums != nullptr) {
      depth_tiles(settings, pass.residuals, segments, num_segments, tile_sums);
    }
  }
  flush(pass.photometric, settings.with_brightness ? 8 : 6, sums.photometric);
  flush(pass.depth, settings.with_scale ? 7 : 6, sums.depth);
  sums.good += sum_lanes(pass.good);
  sums.usage += sum_lanes(pass.usage);
}

}  // namespace raylign::tracking
