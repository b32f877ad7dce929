// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/aligner.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/tracking/alignment_problem.h"
#include "raylign/tracking/assessment.h"
#include "raylign/tracking/maps.h"

namespace raylign {
namespace {

using tracking::AlignmentProblem;
using tracking::BlockSums;
using tracking::PointPass;
using tracking::PoseState;
using tracking::TermScales;
using tracking::TermSums;

constexpr double kRigidTolerance = 1e-6;
// Exact depth has no dispersion at all; the sums are in float.
constexpr double kMaxWeight = 1e3;
constexpr double kMaxScale = 30.0;
// Σ ρ′ n² / Σ ρ′ below which σ_r is scaled, that at which it is right, and how often it is.
constexpr double kMuchSmaller = 0.25;
constexpr double kSettled = 0.7;
constexpr int kMaxAdaptations = 8;
constexpr int kMinSide = 3;  // px: smaller levels have no inner pixel
// px of the coarsest level: a turn below it does not make another start.
constexpr double kSmallTurn = 0.5;

double scale_of(const Matrix4& T) { return std::cbrt(T.topLeftCorner<3, 3>().determinant()); }

// [sR t; 0 1] with R a rotation; s = 1 unless `may_scale`.
void require_motion(const Matrix4& T, bool may_scale) {
  const double s = may_scale ? scale_of(T) : 1.0;
  const Matrix3 R = T.topLeftCorner<3, 3>() / s;
  const bool is_motion = T.allFinite() && s > 0.0 && R.determinant() > 0.0 &&
                         (R * R.transpose() - Matrix3::Identity()).norm() < kRigidTolerance &&
                         T.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (is_motion) return;
  throw OptionsError(std::string("T_init must be a ") +
                     (may_scale ? "similarity [sR t; 0 1]" : "rigid motion [R t; 0 1]"));
}

// Products of exponentials drift off the group by rounding only; here they are brought back.
Matrix4 on_group(const Matrix4& T) {
  const double s = scale_of(T);
  Matrix4 result = T;
  const Matrix3 R = T.topLeftCorner<3, 3>() / s;
  result.topLeftCorner<3, 3>() = s * Eigen::Quaterniond(R).normalized().toRotationMatrix();
  return result;
}

template <typename Motion>
std::vector<int> free_columns(const TrackingOptions& options) {
  std::vector<int> columns;
  for (int k = 0; k < Motion::kSize; ++k) columns.push_back(Motion::kFirst + k);
  if (options.affine.mode != AffineMode::JOINT) return columns;
  columns.push_back(tracking::kColumnA);
  columns.push_back(tracking::kColumnB);
  return columns;
}

// The last level that is worth tracking on, and the first.
struct LevelRange {
  int finest;
  int coarsest;
};

LevelRange level_range(const Keyframe& keyframe,
                       const Frame& target,
                       const TrackingOptions& options) {
  int last = std::min(keyframe.num_levels(), target.num_levels()) - 1;
  while (last > 0 && std::min({keyframe.frame().width(last), keyframe.frame().height(last),
                               target.width(last), target.height(last)}) < kMinSide) {
    --last;
  }
  const int coarsest = std::min(options.coarsest_level, last);
  return {std::min(options.finest_level, coarsest), coarsest};
}

void fail(AlignmentStatus status, const std::string& reason, AlignmentResult& result) {
  result.status = status;
  result.reason = reason;
}

// False, with status and reason, when the keyframe has nothing to align.
bool has_enough_points(const PointList& points,
                       const AcceptanceOptions& limits,
                       AlignmentResult& result) {
  result.num_points = points.num_points();
  result.mean_inverse_depth = points.mean_inverse_depth();
  if (points.num_points() >= limits.min_points) return true;
  const std::string count = std::to_string(points.num_points()) + " points";
  if (points.num_with_depth() >= limits.min_points) {
    fail(AlignmentStatus::LOW_TEXTURE,
         count + " of " + std::to_string(points.num_with_depth()) +
             " pixels with depth have enough gradient (min_points)",
         result);
  } else {
    fail(AlignmentStatus::TOO_FEW_POINTS, count + " with depth (min_points)", result);
  }
  return false;
}

// The scales of the next level from the residuals of this one (docs/theory/tracking.md): the depth
// term's robust scale, and the ratio of the terms' over-dispersions, which is how many points of
// one tell as much as one of the other when blocks count as correlated.
TermScales estimate_scales(const BlockSums& blocks,
                           const TrackingOptions& options,
                           const TermScales& scales) {
  const double photometric = tracking::over_dispersion(blocks, options, false);
  const double depth = tracking::over_dispersion(blocks, options, true);
  const TermSums& sums = blocks.sums.depth;
  if (!(photometric > 0.0) || !(depth > 0.0) || !(sums.weighted_square > 0.0)) return scales;
  TermScales next;
  const double change = std::sqrt(sums.weighted_square / sums.weight);
  next.depth_scale = std::clamp(scales.depth_scale * change, 1.0 / kMaxScale, kMaxScale);
  const double growth = next.depth_scale / scales.depth_scale;
  next.depth_weight = options.depth.weight * growth * growth *
                      std::clamp(photometric / depth, 1.0 / kMaxWeight, kMaxWeight);
  return next;
}

// Of the start's rotation. Brightness stays as it is: where it may move, it makes up for a wrong
// pose.
TrackingOptions for_rotation(TrackingOptions options) {
  options.motion = MotionGroup::SO3;
  options.affine.mode = AffineMode::NONE;
  options.depth.enabled = false;
  return options;
}

// While residuals are much smaller than σ_r says, brings it to them and minimises again: to the
// fixed point of the robust scale, as outliers that a wide σ_r let count fade away.
template <typename Problem>
Summary adapt_sigma(Problem& problem,
                    const TrackingOptions& options,
                    const LmOptions& lm,
                    int num_points,
                    Summary summary) {
  const double lowest = options.min_sigma_intensity / options.sigma_intensity;
  for (int i = 0; i < kMaxAdaptations; ++i) {
    const TermSums& sums = problem.sums().photometric;
    const double scale = problem.scales().photometric_scale;
    const double variance = sums.weight > 0.0 ? sums.weighted_square / sums.weight : 1.0;
    if (!(variance < (i == 0 ? kMuchSmaller : kSettled)) || !(scale > lowest)) break;
    problem.set_photometric_scale(std::max(lowest, scale * std::sqrt(variance)));
    summary = minimize(problem, lm, IterationCallback(), Stopwatch(), num_points);
  }
  return summary;
}

}  // namespace

Aligner::Aligner(const TrackingOptions& options)
    : options_((options.validate(), options)),
      rotation_options_(for_rotation(options)),
      pool_(options.lm.num_threads) {}

Aligner::LevelStart Aligner::turned(const Keyframe& keyframe,
                                    const Frame& target,
                                    int level,
                                    const PoseState& start) {
  PointPass pass(keyframe, target, level, rotation_options_, pool_, workspace_);
  AlignmentProblem<tracking::So3Motion> problem(pass, rotation_options_, start, TermScales());
  LmOptions lm = options_.lm;
  lm.max_num_iterations = options_.max_iterations(level);
  minimize(problem, lm, IterationCallback(), Stopwatch(), pass.num_points());
  return {problem.state(), problem.num_evaluations()};
}

// `start`, or where it is first turned by much the cheaper of both as the level aligns them.
template <typename Motion>
Aligner::LevelStart Aligner::better_start(const Keyframe& keyframe,
                                          const Frame& target,
                                          int level,
                                          const PoseState& start) {
  LevelStart other = turned(keyframe, target, level, start);
  const Matrix3 turn = other.state.T_th.topLeftCorner<3, 3>() *
                       start.T_th.topLeftCorner<3, 3>().transpose() /
                       std::pow(scale_of(start.T_th), 2);
  const double f = target.camera(level).fx();
  if (!(f * Eigen::AngleAxisd(turn).angle() > kSmallTurn)) {
    return {start, other.num_evaluations};
  }
  TermScales scales;
  scales.depth_weight = options_.depth.weight;
  PointPass pass(keyframe, target, level, options_, pool_, workspace_);
  LmOptions lm = options_.lm;
  lm.max_num_iterations = options_.max_iterations(level);
  const auto solve = [&](PoseState& state) {
    AlignmentProblem<Motion> problem(pass, options_, state, scales);
    const Summary summary = minimize(problem, lm, IterationCallback(), Stopwatch(), 0);
    state = problem.state();
    other.num_evaluations += problem.num_evaluations();
    return summary.final_cost;
  };
  PoseState unturned = start;
  const double cost = solve(unturned);
  if (!(solve(other.state) < cost)) other.state = unturned;
  return other;
}

AlignmentResult Aligner::align(const Keyframe& keyframe,
                               const Frame& target,
                               const AlignmentStart& start,
                               bool with_maps) {
  const bool is_sim3 = options_.motion == MotionGroup::SIM3;
  require_motion(start.T_th, is_sim3);
  if (is_sim3 && !target.has_depth()) {
    throw OptionsError("MotionGroup.SIM3 needs a target with depth: intensities do not see scale");
  }
  switch (options_.motion) {
    case MotionGroup::SO3:
      return align_motion<tracking::So3Motion>(keyframe, target, start, with_maps);
    case MotionGroup::SIM3:
      return align_motion<tracking::Sim3Motion>(keyframe, target, start, with_maps);
    case MotionGroup::SE3:
      break;
  }
  return align_motion<tracking::Se3Motion>(keyframe, target, start, with_maps);
}

template <typename Motion>
AlignmentResult Aligner::align_motion(const Keyframe& keyframe,
                                      const Frame& target,
                                      const AlignmentStart& start,
                                      bool with_maps) {
  AlignmentResult result;
  result.motion = options_.motion;
  result.T_th = start.T_th;
  const LevelRange levels = level_range(keyframe, target, options_);
  if (!has_enough_points(keyframe.points(levels.finest), options_.acceptance, result)) {
    return result;
  }
  LevelStart first = {{start.T_th, start.a, start.b}, 0};
  if (options_.rotation_first && options_.motion != MotionGroup::SO3 &&
      keyframe.points(levels.coarsest).num_points() >= options_.acceptance.min_points) {
    first = better_start<Motion>(keyframe, target, levels.coarsest, first.state);
  }
  PoseState state = first.state;
  TermScales scales;
  scales.depth_weight = options_.depth.weight;
  LmOptions lm = options_.lm;
  for (int level = levels.coarsest; level >= levels.finest; --level) {
    // a level too poor to say anything is passed over
    if (keyframe.points(level).num_points() < options_.acceptance.min_points) continue;
    const Stopwatch clock;
    PointPass pass(keyframe, target, level, options_, pool_, workspace_);
    const bool is_last = level == levels.finest;
    const Shutter& shutter = start.shutter;
    const Vector6 velocity = shutter.target_velocity(state.T_th);
    if (shutter.has_motion) {
      pass.set_sweep(shutter.readout_s * shutter.host_velocity, shutter.readout_s * velocity);
    }
    const bool estimates = pass.has_depth_term() && options_.depth.estimate_weight;
    AlignmentProblem<Motion> problem(pass, options_, state, scales, is_last || estimates);
    lm.max_num_iterations = options_.max_iterations(level);
    LevelResult record;
    record.summary = minimize(problem, lm, IterationCallback(), clock, pass.num_points());
    if (is_last && options_.adapt_sigma) {
      record.summary = adapt_sigma(problem, options_, lm, pass.num_points(), record.summary);
      scales = problem.scales();
      result.sigma_scale = scales.photometric_scale;
    }
    state = problem.state();
    record.level = level;
    record.num_points = pass.num_points();
    record.depth_weight = pass.has_depth_term() ? scales.depth_weight : 0.0;
    if (is_last || estimates) problem.thaw();
    record.num_evaluations = problem.num_evaluations() + std::exchange(first.num_evaluations, 0);
    result.levels.push_back(std::move(record));
    const BlockSums blocks = {problem.sums(), problem.tiles()};
    if (!is_last) {
      if (estimates) scales = estimate_scales(blocks, options_, scales);
      continue;
    }
    result.T_th = on_group(state.T_th);
    result.a = state.a;
    result.b = state.b;
    tracking::set_agreement(blocks, pass.num_points(), result);
    tracking::set_uncertainty(blocks, free_columns<Motion>(options_), options_,
                              pass.has_depth_term() ? scales.depth_weight : 0.0, result);
    if (shutter.has_motion) {
      result.readout = tracking::readout_equation(
          problem.bands(), pass.band_twists(state.T_th, shutter.host_velocity, velocity),
          free_columns<Motion>(options_), options_,
          pass.has_depth_term() ? scales.depth_weight : 0.0);
    }
    tracking::set_status(options_, result);
    if (with_maps) {
      result.maps = tracking::make_maps(keyframe, target, level, pass.settings(state, scales));
    }
  }
  return result;
}

std::string to_string(AlignmentStatus status) {
  switch (status) {
    case AlignmentStatus::OK:
      return "ok";
    case AlignmentStatus::LOST_OVERLAP:
      return "lost_overlap";
    case AlignmentStatus::TOO_FEW_POINTS:
      return "too_few_points";
    case AlignmentStatus::DIVERGED:
      return "diverged";
    case AlignmentStatus::NOT_CONVERGED:
      return "not_converged";
    case AlignmentStatus::DEGENERATE:
      return "degenerate";
    case AlignmentStatus::LOW_TEXTURE:
      return "low_texture";
    case AlignmentStatus::MOTION_BOUND:
      return "motion_bound";
  }
  return "unknown";
}

}  // namespace raylign
