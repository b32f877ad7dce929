// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/point_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raylign/geometry/se3.h"

namespace raylign::tracking {
namespace {

constexpr std::int64_t kBandPoints = 1024;

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

void set_pose(const Matrix4& T, PassSettings& s) {
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) s.pose.R[3 * row + k] = static_cast<float>(T(row, k));
    s.pose.t[row] = static_cast<float>(T(row, 3));
  }
}

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
      host_camera_(keyframe.frame().camera(level)),
      host_width_(keyframe.frame().width(level)),
      host_height_(keyframe.frame().height(level)),
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
  make_bands();
}

void PointPass::make_bands() {
  const std::vector<PointList::Tile>& tiles = points_.tiles();
  std::size_t begin = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const bool is_last = i + 1 == tiles.size();
    if (!is_last && tiles[i].end - tiles[begin].begin < kBandPoints) continue;
    const auto first = static_cast<std::size_t>(tiles[begin].begin);
    const auto last = static_cast<std::size_t>(tiles[i].begin + tiles[i].count - 1);
    const std::vector<std::int32_t>& pixels = points_.pixels();
    const int row_sum = pixels[first] / host_width_ + pixels[last] / host_width_;
    bands_.push_back({begin, i + 1, 0.5 * row_sum});
    begin = i + 1;
  }
}

PassSettings PointPass::settings(const PoseState& state, const TermScales& scales) const {
  PassSettings s = {};
  const Matrix3 R = state.T_th.topLeftCorner<3, 3>();
  set_pose(state.T_th, s);
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
  s.photometric_scale = static_cast<float>(scales.photometric_scale);
  s.depth_scale = static_cast<float>(scales.depth_scale);
  return s;
}

std::vector<Vector6> PointPass::band_twists(const Matrix4& T_th,
                                            const Vector6& host_sweep,
                                            const Vector6& target_sweep) const {
  const Vector6 host = se3_adjoint(T_th) * host_sweep;
  const double depth = 1.0 / points_.mean_inverse_depth();
  const double u = 0.5 * (host_width_ - 1);
  std::vector<Vector6> twists;
  twists.reserve(bands_.size());
  for (const Band& band : bands_) {
    const Vector3 ray((u - host_camera_.cx()) / host_camera_.fx(),
                      (band.row - host_camera_.cy()) / host_camera_.fy(), 1.0);
    const Vector3 X = T_th.topLeftCorner<3, 3>() * (depth * ray) + T_th.topRightCorner<3, 1>();
    const double row = X.z() > 0.0 ? camera_.fy() * X.y() / X.z() + camera_.cy() : band.row;
    const double s_host = (band.row + 0.5) / host_height_ - 0.5;
    const double s_target = std::clamp((row + 0.5) / target_.height - 0.5, -0.5, 0.5);
    twists.emplace_back(s_target * target_sweep - s_host * host);
  }
  return twists;
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
  std::vector<PassSums>& sums = out.bands;
  sums.assign(bands_.size(), PassSums{});
  std::vector<Vector6> twists;
  if (is_swept_) twists = band_twists(state.T_th, host_sweep_, target_sweep_);
  pool_.run(static_cast<int>(bands_.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const Band& band = bands_[k];
    PassSettings own = s;
    if (is_swept_) set_pose(se3_exp(twists[k]) * state.T_th, own);
    evaluate(arrays, target_, own, tiles.data() + band.begin,
             static_cast<int>(band.end - band.begin), precisions, sums[k],
             with_tiles ? out.tiles.data() + band.begin : nullptr);
  });
  PassSums total;
  for (const PassSums& band : sums) {
    add(band.photometric, total.photometric);
    add(band.depth, total.depth);
    total.good += band.good;
    total.usage += band.usage;
  }
  return total;
}

}  // namespace raylign::tracking
