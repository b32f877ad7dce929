// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/rgbd_odometry.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/se3.h"

namespace raylign {
namespace {

// Starts that are followed down to the finest level after all were tried on the coarsest.
constexpr std::size_t kFinalists = 2;
// A frame is aligned anew while the readout time moves its first and last rows by more px, and no
// more often.
constexpr double kReadoutTolerance = 0.1;
constexpr int kMaxRealignments = 3;
// A pose that stands beside one too far from where depth has the camera must be nearer by much.
constexpr double kMuchBetter = 0.5;

TrackingOptions on_coarsest_level(TrackingOptions options) {
  options.finest_level = options.coarsest_level;
  return options;
}

TrackingOptions on_finest_level(TrackingOptions options) {
  options.coarsest_level = options.finest_level;
  options.rotation_first = false;
  return options;
}

// Products of many rotations leave SO(3) bit by bit.
Matrix4 without_drift(const Matrix4& T) {
  Matrix4 result = T;
  result.topLeftCorner<3, 3>() =
      quaternion_to_matrix(quaternion_from_matrix(T.topLeftCorner<3, 3>()));
  return result;
}

}  // namespace

std::string to_string(OdometryStatus status) {
  switch (status) {
    case OdometryStatus::OK:
      return "ok";
    case OdometryStatus::RECOVERED:
      return "recovered";
    case OdometryStatus::LOST:
      return "lost";
    case OdometryStatus::NO_DEPTH:
      break;
  }
  return "no_depth";
}

RgbdOdometry::RgbdOdometry(const PinholeCamera& camera,
                           const OdometryOptions& options,
                           const Matrix4& T_wc)
    : camera_(camera),
      options_((options.validate(), options)),
      T_cw_first_(se3_inverse(T_wc)),
      motion_(options.motion),
      readout_(options.shutter),
      converter_(options.depth_model),
      aligner_(options.tracking),
      coarse_aligner_(on_coarsest_level(options.tracking)),
      fine_aligner_(on_finest_level(options.tracking)) {
  camera.validate();
  sensed_.scale = options_.depth_scale;
  sensed_.model = options_.depth_model;
  sensed_.max_difference = options_.tracking.depth.max_difference;
}

OdometryResult RgbdOdometry::track(const ImageView& image,
                                   const ImageView& depth,
                                   double timestamp) {
  check_input(image, depth, timestamp);
  const std::shared_ptr<Shot> shot = make_shot(image, depth);
  sensed_.image = depth;
  last_timestamp_ = timestamp;
  OdometryResult result;
  result.frame = num_frames_++;
  result.timestamp = timestamp;
  const bool is_tracked = keyframes_.empty() ? start(shot, result)
                          : is_lost_         ? recover(*shot->frame, result)
                                             : follow(*shot->frame, result);
  if (is_tracked) {
    if (!is_lost_) refine_readout(keyframes_.back(), *shot->frame, result);
    finish(shot, result);
  } else {
    result.status = keyframes_.empty() ? OdometryStatus::NO_DEPTH : OdometryStatus::LOST;
    result.T_wc.setConstant(std::numeric_limits<double>::quiet_NaN());
    is_lost_ = !keyframes_.empty();
  }
  result.readout_s = readout_.readout_s();
  return result;
}

void RgbdOdometry::check_input(const ImageView& image, const ImageView& depth, double timestamp) {
  require_option(std::isfinite(timestamp) && (num_frames_ == 0 || timestamp > last_timestamp_),
                 "timestamp", "finite and larger than the one before (s)", timestamp);
  if (num_frames_ == 0) {
    width_ = image.width;
    height_ = image.height;
  }
  const auto require_size = [&](const ImageView& view, const char* name) {
    if (view.width == width_ && view.height == height_) return;
    throw ShapeError(std::string(name) + " must have the size of the first image, (" +
                     std::to_string(height_) + ", " + std::to_string(width_) + "), got (" +
                     std::to_string(view.height) + ", " + std::to_string(view.width) + ")");
  };
  require_size(image, "image");
  require_size(depth, "depth");
}

// A frame that nobody holds any more is filled again: in the long run nothing is allocated.
std::shared_ptr<RgbdOdometry::Shot> RgbdOdometry::make_shot(const ImageView& image,
                                                            const ImageView& depth) {
  const int num_levels = options_.tracking.coarsest_level + 1;
  const auto free = std::find_if(pool_.begin(), pool_.end(),
                                 [](const auto& shot) { return shot.use_count() == 1; });
  std::shared_ptr<Shot> shot;
  if (free == pool_.end()) {
    shot = pool_.emplace_back(std::make_shared<Shot>());
    shot->frame = std::make_shared<Frame>(image, camera_, num_levels);
  } else {
    shot = *free;
    shot->frame->assign(image, camera_, num_levels);
  }
  if (options_.tracking.depth.enabled) {
    set_depth(depth, *shot->frame);
    return shot;
  }
  converter_.check(depth, options_.depth_scale);
  shot->depth.resize(depth.row_bytes() * static_cast<std::size_t>(depth.height));
  shot->depth_view = depth;
  shot->depth_view.data = shot->depth.data();
  shot->depth_view.row_stride = depth.row_bytes();
  for (int v = 0; v < depth.height; ++v) {
    const auto row = static_cast<std::size_t>(v);
    std::memcpy(shot->depth.data() + row * depth.row_bytes(),
                static_cast<const std::byte*>(depth.data) + row * depth.row_stride,
                depth.row_bytes());
  }
  return shot;
}

void RgbdOdometry::set_depth(const ImageView& depth, Frame& frame) {
  D_.resize(depth.width, depth.height);
  V_.resize(depth.width, depth.height);
  converter_.convert(depth, options_.depth_scale, D_.data(), V_.data());
  frame.adopt_depth(D_, V_);
}

bool RgbdOdometry::start(const std::shared_ptr<Shot>& shot, OdometryResult& result) {
  if (!add_keyframe(shot, T_cw_first_, result.frame)) {
    result.reason = "too few pixels with depth and gradient to start from";
    return false;
  }
  result.T_wc = se3_inverse(T_cw_first_);
  result.keyframe = result.frame;
  return true;
}

bool RgbdOdometry::follow(const Frame& frame, OdometryResult& result) {
  const Matrix4 T_predicted = motion_.predict(result.timestamp);
  const std::vector<Matrix4> alternatives = motion_.alternatives(result.timestamp);
  if (try_start(keyframes_.back(), frame, T_predicted, result) ||
      try_best_of(keyframes_.back(), frame, alternatives, result)) {
    return true;
  }
  // The frame before is nearer than the keyframe. Should this fail, too, it is where a lost camera
  // will most likely be found again, so it stays.
  if (previous_number_ == keyframes_.back().frame ||
      !add_keyframe(previous_, motion_.last(), previous_number_)) {
    return false;
  }
  return try_start(keyframes_.back(), frame, T_predicted, result) ||
         try_best_of(keyframes_.back(), frame, alternatives, result);
}

// Newest first: a lost camera is most often still near.
bool RgbdOdometry::recover(const Frame& frame, OdometryResult& result) {
  for (auto reference = keyframes_.rbegin(); reference != keyframes_.rend(); ++reference) {
    std::vector<Matrix4> starts = {reference->T_kw};
    for (const Matrix4& T_cw : motion_.turned(reference->T_kw)) starts.push_back(T_cw);
    starts.push_back(motion_.last());
    if (try_best_of(*reference, frame, starts, result)) return true;
  }
  return false;
}

bool RgbdOdometry::try_start(Placed& reference,
                             const Frame& frame,
                             const Matrix4& T_cw,
                             OdometryResult& result) {
  Found found = align(aligner_, reference, frame, T_cw);
  ++result.num_alignments;
  if (found.depth_step > options_.max_depth_step) {
    // what the intensities follow may move by itself; beside it lies the world that depth shows
    Found other = align(fine_aligner_, reference, frame, found.T_cw_by_depth);
    ++result.num_alignments;
    if (other.alignment.status == AlignmentStatus::OK &&
        other.depth_step < kMuchBetter * found.depth_step) {
      found = std::move(other);
    }
  }
  judge_depth_step(found.depth_step, found.alignment);
  result.alignment = std::move(found.alignment);
  const AlignmentResult& alignment = result.alignment;
  result.keyframe = reference.frame;
  result.reason = alignment.status == AlignmentStatus::OK ? "" : alignment.reason;
  if (alignment.status != AlignmentStatus::OK) return false;
  result.T_wc = se3_inverse(without_drift(alignment.T_th * reference.T_kw));
  reference.a = alignment.a;
  reference.b = alignment.b;
  return true;
}

RgbdOdometry::Found RgbdOdometry::align(Aligner& aligner,
                                        const Placed& reference,
                                        const Frame& frame,
                                        const Matrix4& T_cw) {
  const AlignmentStart start{T_cw * se3_inverse(reference.T_kw), reference.a, reference.b,
                             shutter(reference)};
  Found found;
  found.alignment = aligner.align(*reference.keyframe, frame, start);
  AlignmentResult& alignment = found.alignment;
  judge(reference, without_drift(alignment.T_th * reference.T_kw), alignment);
  // the depth term has had its say
  if (alignment.status != AlignmentStatus::OK || options_.tracking.depth.enabled) return found;
  const Vector6 step =
      depth_step(coarsest_points(*reference.keyframe), alignment.T_th, camera_, sensed_);
  found.depth_step =
      std::hypot(step.head<3>().norm() * alignment.mean_inverse_depth, step.tail<3>().norm());
  found.T_cw_by_depth = se3_exp(step) * alignment.T_th * reference.T_kw;
  return found;
}

// Enough to hold a pose against a depth image, and few.
const PointList& RgbdOdometry::coarsest_points(const Keyframe& keyframe) const {
  return keyframe.points(std::min(options_.tracking.coarsest_level, keyframe.num_levels() - 1));
}

void RgbdOdometry::judge_depth_step(double step, AlignmentResult& alignment) const {
  if (alignment.status != AlignmentStatus::OK || step <= options_.max_depth_step) return;
  alignment.status = AlignmentStatus::DIVERGED;
  alignment.reason = "by the frame's depth the camera is elsewhere, by " + format_double(step) +
                     " of the mean depth or rad (max_depth_step)";
}

Shutter RgbdOdometry::shutter(const Placed& reference) const {
  Shutter shutter;
  shutter.readout_s = readout_.readout_s();
  shutter.has_motion = !is_lost_ && motion_.has_last() &&
                       (options_.shutter.estimate_readout || shutter.readout_s != 0.0);
  if (!shutter.has_motion) return shutter;
  shutter.host_velocity = reference.velocity;
  shutter.T_before_h = motion_.last() * se3_inverse(reference.T_kw);
  shutter.elapsed_s = last_timestamp_ - motion_.last_timestamp();
  return shutter;
}

// By how much readout_s shifts the target's first and last rows against the keyframe's.
double RgbdOdometry::sweep_px(const Placed& reference,
                              const OdometryResult& result,
                              double readout_s) const {
  const Matrix4& T_th = result.alignment.T_th;
  const Vector6 sweep =
      0.5 * readout_s *
      (shutter(reference).target_velocity(T_th) - se3_adjoint(T_th) * reference.velocity);
  return camera_.fx() *
         (sweep.tail<3>().norm() + sweep.head<3>().norm() * result.alignment.mean_inverse_depth);
}

void RgbdOdometry::refine_readout(Placed& reference, const Frame& frame, OdometryResult& result) {
  if (!options_.shutter.estimate_readout || !(result.alignment.readout.information > 0.0)) return;
  // no row is read when the next frame's turn has come
  const double bound_s = last_timestamp_ - motion_.last_timestamp();
  for (int i = 0; i <= kMaxRealignments; ++i) {
    const double step_s = readout_.move(result.alignment.readout, bound_s);
    if (i == kMaxRealignments ||
        sweep_px(reference, result, std::abs(step_s)) < kReadoutTolerance) {
      break;
    }
    OdometryResult again = result;
    const bool is_ok = try_start(reference, frame, se3_inverse(result.T_wc), again);
    result.num_alignments = again.num_alignments;
    if (!is_ok) break;
    result = std::move(again);
  }
  readout_.keep();
}

// An alignment that is OK by itself may still not be believed.
void RgbdOdometry::judge(const Placed& reference,
                         const Matrix4& T_cw,
                         AlignmentResult& alignment) const {
  if (alignment.status != AlignmentStatus::OK) return;
  if (!is_lost_ && !motion_.is_plausible(T_cw, alignment.mean_inverse_depth)) {
    alignment.status = AlignmentStatus::MOTION_BOUND;
    alignment.reason =
        "the step from the frame before is larger than max_frame_translation or "
        "max_frame_rotation";
    return;
  }
  if (alignment.agreement >= options_.keyframe_rule.min_agreement) return;
  // the images alone leave doubt
  const double share =
      depth_agreement(coarsest_points(*reference.keyframe), alignment.T_th, camera_, sensed_);
  if (share >= options_.min_depth_agreement) return;
  alignment.status = AlignmentStatus::DIVERGED;
  alignment.reason = "only " + format_double(std::round(1000.0 * share) / 10.0) +
                     " % of the points land on the frame's depth (min_depth_agreement)";
}

// All starts on the coarsest level, the best of them down to the finest.
bool RgbdOdometry::try_best_of(Placed& reference,
                               const Frame& frame,
                               const std::vector<Matrix4>& starts,
                               OdometryResult& result) {
  std::vector<std::pair<double, Matrix4>> found;
  for (const Matrix4& T_cw : starts) {
    const AlignmentStart start{T_cw * se3_inverse(reference.T_kw), reference.a, reference.b, {}};
    const AlignmentResult coarse = coarse_aligner_.align(*reference.keyframe, frame, start);
    ++result.num_alignments;
    const double score = coarse.agreement * coarse.overlap;
    const Matrix4 T_cw_found = without_drift(coarse.T_th * reference.T_kw);
    if (std::isfinite(score) && T_cw_found.allFinite()) found.emplace_back(score, T_cw_found);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (std::size_t i = 0; i < std::min(kFinalists, found.size()); ++i) {
    if (try_start(reference, frame, found[i].second, result)) return true;
  }
  return false;
}

bool RgbdOdometry::needs_keyframe(const OdometryResult& result) const {
  const KeyframeRule& rule = options_.keyframe_rule;
  const AlignmentResult& alignment = result.alignment;
  const double distance = rule.distance_weight * alignment.T_th.topRightCorner<3, 1>().norm() *
                          alignment.mean_inverse_depth;
  const double unseen = rule.usage_weight * (1.0 - alignment.usage);
  return distance * distance + unseen * unseen > 1.0 ||
         alignment.good_ratio < rule.min_good_ratio || alignment.agreement < rule.min_agreement;
}

// False when the frame has too few points to be one.
bool RgbdOdometry::add_keyframe(const std::shared_ptr<Shot>& shot,
                                const Matrix4& T_cw,
                                std::int64_t number) {
  if (!shot->frame->has_depth()) set_depth(shot->depth_view, *shot->frame);
  auto keyframe = std::make_shared<Keyframe>(shot->frame, options_.keyframe);
  const int finest = std::min(options_.tracking.finest_level, keyframe->num_levels() - 1);
  if (keyframe->points(finest).num_points() < options_.tracking.acceptance.min_points) return false;
  keyframes_.push_back({shot, std::move(keyframe), T_cw, number, velocity_});
  if (static_cast<int>(keyframes_.size()) > options_.num_recovery_keyframes) {
    keyframes_.pop_front();
  }
  return true;
}

// A keyframe's velocity is known best when the frame after it is: the mean of the two steps.
void RgbdOdometry::update_velocities(const Matrix4& T_cw, double timestamp) {
  velocity_.setZero();
  if (is_lost_ || !motion_.has_last()) return;
  const double elapsed_s = timestamp - motion_.last_timestamp();
  velocity_ = se3_log(T_cw * se3_inverse(motion_.last())) / elapsed_s;
  Placed& newest = keyframes_.back();
  if (newest.frame != previous_number_) return;
  newest.velocity =
      motion_.has_velocity() ? Vector6(0.5 * (velocity_ + motion_.velocity())) : velocity_;
}

void RgbdOdometry::finish(const std::shared_ptr<Shot>& shot, OdometryResult& result) {
  const Matrix4 T_cw = se3_inverse(result.T_wc);
  update_velocities(T_cw, result.timestamp);
  result.status = is_lost_ ? OdometryStatus::RECOVERED : OdometryStatus::OK;
  motion_.update(T_cw, result.timestamp, is_lost_);
  is_lost_ = false;
  result.is_keyframe = result.keyframe == result.frame ||
                       (needs_keyframe(result) && add_keyframe(shot, T_cw, result.frame));
  previous_ = shot;
  previous_number_ = result.frame;
}

}  // namespace raylign
