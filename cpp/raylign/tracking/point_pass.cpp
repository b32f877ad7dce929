// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/point_pass.h"

#include <cmath>
#include <limits>

namespace raylign::tracking {
namespace {

constexpr std::int64_t kChunkPoints = 1024;

void add(const TermSums& term, TermSums& sum) {
  for (int k = 0; k < kMaxTriangle; ++k) sum.H[k] += term.H[k];
  for (int k = 0; k < kMaxColumns; ++k) sum.g[k] += term.g[k];
  sum.rho += term.rho;
  sum.rho_reference += term.rho_reference;
  sum.count += term.count;
  sum.weight += term.weight;
  sum.weighted_square += term.weighted_square;
}

// The angle about the optical axis that is left of R once the axis has been brought back along the
// shortest way: the twist of the swing-twist decomposition.
double roll_of(const Matrix3& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

}  // namespace

PointPass::PointPass(const Keyframe& keyframe,
                     const Frame& target,
                     int level,
                     const TrackingOptions& options,
                     ThreadPool& pool,
                     Workspace& workspace)
    : points_(keyframe.points(level)),
      target_{target.gradients(level).data(), nullptr, target.width(level), target.height(level)},
      camera_(target.camera(level)),
      level_(level),
      options_(options),
      pool_(pool),
      workspace_(workspace) {
  const auto size = static_cast<std::size_t>(points_.padded_size());
  const bool with_depth = options.depth.enabled && target.has_depth();
  if (with_depth) target_.depth = target.depth_cells(level).data();
  for (PassBuffers& buffers : workspace_.buffers) {
    buffers.photometric.resize(size);
    buffers.depth.resize(with_depth ? size : 0);
    buffers.tiles.resize(points_.tiles().size());
  }
  make_chunks();
}

void PointPass::make_chunks() {
  const std::vector<PointList::Tile>& tiles = points_.tiles();
  std::size_t begin = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const bool is_last = i + 1 == tiles.size();
    if (!is_last && tiles[i].end - tiles[begin].begin < kChunkPoints) continue;
    chunks_.push_back({begin, i + 1});
    begin = i + 1;
  }
}

PassSettings PointPass::settings(const PoseState& state, const TermScales& scales) const {
  PassSettings s = {};
  const Matrix3 R = state.T_th.topLeftCorner<3, 3>();
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) s.pose.R[3 * row + k] = static_cast<float>(R(row, k));
    s.pose.t[row] = static_cast<float>(state.T_th(row, 3));
  }
  s.pose.fx = static_cast<float>(camera_.fx());
  s.pose.fy = static_cast<float>(camera_.fy());
  s.pose.cx = static_cast<float>(camera_.cx());
  s.pose.cy = static_cast<float>(camera_.cy());
  const double gain = std::exp(state.a);
  const bool exact = options_.noise_model == NoiseModel::EXACT;
  // each level averages four pixels of the one before
  const double variance = options_.sigma_intensity * options_.sigma_intensity *
                          (exact ? std::ldexp(1.0, -2 * level_) : 1.0);
  s.gain = static_cast<float>(gain);
  s.b = static_cast<float>(state.b);
  s.host_variance = static_cast<float>(variance);
  s.target_variance = static_cast<float>(gain * gain * variance);
  s.exact_noise = exact;
  s.esm = options_.gradient == GradientMode::ESM;
  const double roll = roll_of(R);
  s.roll_cos = static_cast<float>(std::cos(roll));
  s.roll_sin = static_cast<float>(std::sin(roll));
  s.with_brightness = options_.affine.mode != AffineMode::NONE;
  s.with_scale = options_.motion == MotionGroup::SIM3;
  // another scale is a difference of all depths, and what SIM3 is to find
  s.depth_gate = s.with_scale ? std::numeric_limits<float>::infinity()
                              : static_cast<float>(options_.depth.max_difference);
  s.depth_gradient = options_.depth.use_gradient;
  s.freeze = options_.sigma_mode == SigmaMode::FROZEN;
  s.loss = &options_.loss;
  s.photometric_scale = 1.0F;
  s.depth_scale = static_cast<float>(scales.depth_scale);
  return s;
}

PassSums PointPass::run(const PoseState& state,
                        const TermScales& scales,
                        const PassBuffers* reference,
                        PassBuffers& out,
                        bool with_tiles) {
  PassSettings s = settings(state, scales);
  if (reference != nullptr) {
    s.reference_photometric = reference->photometric.data();
    s.reference_depth = has_depth_term() ? reference->depth.data() : nullptr;
  }
  const PointArrays arrays = points_.arrays();
  const PrecisionArrays precisions = {out.photometric.data(), out.depth.data()};
  const std::vector<PointList::Tile>& tiles = points_.tiles();
  std::vector<PassSums>& sums = workspace_.chunk_sums;
  sums.assign(chunks_.size(), PassSums{});
  pool_.run(static_cast<int>(chunks_.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const Chunk& chunk = chunks_[k];
    evaluate(arrays, target_, s, tiles.data() + chunk.begin,
             static_cast<int>(chunk.end - chunk.begin), precisions, sums[k],
             with_tiles ? out.tiles.data() + chunk.begin : nullptr);
  });
  PassSums total;
  for (const PassSums& chunk : sums) {
    add(chunk.photometric, total.photometric);
    add(chunk.depth, total.depth);
    total.good += chunk.good;
    total.usage += chunk.usage;
  }
  return total;
}

}  // namespace raylign::tracking
