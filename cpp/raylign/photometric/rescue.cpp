// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/rescue.h"

#include <algorithm>
#include <cmath>

#include "raylign/geometry/se3.h"
#include "raylign/photometric/constraints.h"
#include "raylign/photometric/matches.h"

namespace raylign::photometric {
namespace {

constexpr std::int64_t kMinPoints = 20;
constexpr std::int64_t kMaxPoints = 600;  // enough for six numbers
constexpr double kTurn = 0.06;            // of the image's width, between two aims
constexpr double kFound = 0.5;            // of the points in view, matched
constexpr int kMaxIterations = 20;
constexpr double kTolerance = 1e-3;  // an aim only has to come near
constexpr double kNoLimit = 1e9;

PhotometricOptions aiming_options(const PhotometricOptions& options) {
  PhotometricOptions aiming = options;
  aiming.visibility.max_residual = kNoLimit;
  aiming.refine_intrinsics = false;
  aiming.lm.max_num_iterations = kMaxIterations;
  aiming.lm.function_tolerance = kTolerance;
  return aiming;
}

// Points that come from a right image and that most right images which see them match.
std::vector<std::int64_t> agreed_points(const Setting& setting,
                                        const Views& views,
                                        const std::vector<bool>& is_lost) {
  std::vector<std::int64_t> points;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    const std::int32_t host = setting.hosts.image[p];
    if (host < 0 || is_lost[host]) continue;
    int seen = 0;
    int matched = 0;
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      const std::int32_t image = views.scene.edges[e].image;
      if (image == host || is_lost[image] || !is_comparable(views, p, e)) continue;
      ++seen;
      if (is_matched(views, p, e)) ++matched;
    }
    if (2 * matched > seen) points.push_back(p);
  }
  const auto step = (static_cast<std::int64_t>(points.size()) + kMaxPoints - 1) / kMaxPoints;
  std::vector<std::int64_t> some;
  for (std::size_t k = 0; k < points.size(); k += std::max<std::int64_t>(step, 1)) {
    some.push_back(points[k]);
  }
  return some;
}

template <typename Table>
Table rows_of(const Table& table, const std::vector<std::int64_t>& rows) {
  if (table.rows() == 0) return table;
  Table some(static_cast<Eigen::Index>(rows.size()), table.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    some.row(static_cast<Eigen::Index>(k)) = table.row(rows[k]);
  }
  return some;
}

// The same images with some of the points, everything about them known.
PhotometricProblem part_of(const Setting& setting,
                           const Views& views,
                           const std::vector<std::int64_t>& points) {
  PhotometricProblem part = setting.problem;
  part.points = rows_of(setting.problem.points, points);
  part.normals = rows_of(views.normals, points);
  part.patches.resize(0, 0);
  part.hosts.resize(0);
  part.host_uv.resize(0, 2);
  part.track_image.resize(0);
  part.track_point.resize(0);
  part.point_covariances.resize(0, 9);
  part.depth_sigmas.resize(0);
  return part;
}

// Every image alone, to be aimed at known points.
class Aim {
 public:
  Aim(const Setting& setting,
      const PatchConstraints& base,
      const PhotometricState& start,
      const PhotometricState& state,
      const std::vector<bool>& is_lost)
      : base_(base),
        start_(start),
        state_(state),
        options_(aiming_options(setting.options)),
        views_(find_views(setting, state, 0)),
        points_(agreed_points(setting, views_, is_lost)),
        problem_(part_of(setting, views_, points_)),
        setting_{problem_, options_, setting.pool, setting.prepared, hosts_of(setting), {}},
        all_(setting.candidates) {
    start_.points = rows_of(start.points, points_);
    state_.points = rows_of(state.points, points_);
    base_.points.assign(points_.size(), true);
    std::fill(base_.intrinsics.begin(), base_.intrinsics.end(),
              std::array<bool, 4>{true, true, true, true});
  }

  /// Whether the image shows the points from a pose found; then `pose` and `brightness` are set.
  bool find(std::int32_t image, Progress& progress, PatchPose& pose, Eigen::Vector2d& brightness) {
    look_through(image);
    for (const PatchPose& from : aims(image)) {
      if (progress.asks_to_stop()) return false;
      PhotometricState state = state_;
      state.poses[image] = from;
      state.brightness.row(image) = start_.brightness.row(image);
      if (!align(state)) continue;
      pose = state.poses[image];
      brightness = state.brightness.row(image).transpose();
      return true;
    }
    return false;
  }

 private:
  PatchHosts hosts_of(const Setting& setting) const {
    PatchHosts hosts;
    for (const std::int64_t p : points_) hosts.image.push_back(setting.hosts.image[p]);
    hosts.uv = rows_of(setting.hosts.uv, points_);
    return hosts;
  }

  // No other image is a candidate, and this one only of points that it may see.
  void look_through(std::int32_t image) {
    Candidates& candidates = setting_.candidates;
    candidates.image.clear();
    candidates.starts.assign(1, 0);
    for (const std::int64_t p : points_) {
      const auto first = all_.image.begin() + all_.starts[p];
      const auto last = all_.image.begin() + all_.starts[p + 1];
      if (std::find(first, last, image) != last) candidates.image.push_back(image);
      candidates.starts.push_back(candidates.size());
    }
    constraints_ = base_;
    for (std::size_t i = 0; i < constraints_.poses.size(); ++i) {
      if (static_cast<std::int32_t>(i) != image) hold_image(i, constraints_);
    }
  }

  std::vector<PatchPose> aims(std::int32_t image) const {
    const double turn = kTurn * setting_.prepared.images[image]->width(0) /
                        start_.intrinsics(start_.intrinsics_row(image), 0);
    std::vector<PatchPose> from_poses = {start_.poses[image]};
    if (!same_pose(start_.poses[image], state_.poses[image])) {
      from_poses.push_back(state_.poses[image]);
    }
    std::vector<PatchPose> poses;
    for (const std::array<int, 2>& to : {std::array<int, 2>{0, 0},
                                         {1, 0},
                                         {-1, 0},
                                         {0, 1},
                                         {0, -1},
                                         {1, 1},
                                         {1, -1},
                                         {-1, 1},
                                         {-1, -1}}) {
      Vector6 xi = Vector6::Zero();
      xi[3] = turn * to[0];
      xi[4] = turn * to[1];
      for (const PatchPose& from : from_poses) {
        const Matrix4 T = se3_exp(xi) * from.matrix();
        poses.push_back(
            {quaternion_from_matrix(T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>()});
      }
    }
    return poses;
  }

  bool align(PhotometricState& state) const {
    if (setting_.candidates.size() < kMinPoints) return false;
    Refinement refinement(setting_, constraints_, start_);
    Refinement::Plan plan;
    plan.num_levels = setting_.prepared.num_levels;
    refinement.run(plan, std::vector<bool>(points_.size(), true), nullptr, state);
    const Views views = find_views(setting_, state, 0);
    std::int64_t seen = 0;
    std::int64_t matched = 0;
    for (std::int64_t p = 0; p < setting_.num_points(); ++p) {
      const std::int64_t e = views.scene.starts[p];
      if (e == views.scene.starts[p + 1] || !is_comparable(views, p, e)) continue;
      ++seen;
      if (is_matched(views, p, e)) ++matched;
    }
    return seen >= kMinPoints && static_cast<double>(matched) >= kFound * static_cast<double>(seen);
  }

  PatchConstraints base_, constraints_;
  PhotometricState start_, state_;
  PhotometricOptions options_;
  Views views_;
  std::vector<std::int64_t> points_;
  PhotometricProblem problem_;
  Setting setting_;
  const Candidates& all_;
};

// Takes the points of an image with it, to the depths that they started with.
void restart_points(const Setting& setting,
                    const std::vector<bool>& is_held,
                    const PhotometricState& start,
                    std::int32_t image,
                    PhotometricState& state) {
  const PatchPose& pose = state.poses[image];
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    if (is_held[p] || setting.hosts.image[p] != image) continue;
    const Vector3 q = start.in_camera(image, start.points.row(p));
    state.points.row(p) = (pose.q.conjugate() * (q - pose.t)).transpose();
  }
}

}  // namespace

std::vector<std::int32_t> find_lost_images(const Setting& setting,
                                           const PatchConstraints& base,
                                           const PhotometricState& start,
                                           const std::vector<bool>& is_lost,
                                           Progress& progress,
                                           PhotometricState& state) {
  std::vector<std::int32_t> wanted, found;
  for (std::size_t i = 0; i < is_lost.size(); ++i) {
    if (is_lost[i] && !base.poses[i].all()) wanted.push_back(static_cast<std::int32_t>(i));
  }
  const auto num_lost = std::count(is_lost.begin(), is_lost.end(), true);
  const bool most_are_right = 2 * num_lost <= static_cast<std::ptrdiff_t>(is_lost.size());
  if (wanted.empty() || !most_are_right) return found;
  Aim aim(setting, base, start, state, is_lost);
  for (const std::int32_t image : wanted) {
    Eigen::Vector2d brightness;
    if (!aim.find(image, progress, state.poses[image], brightness)) continue;
    found.push_back(image);
    state.brightness.row(image) = brightness.transpose();
    restart_points(setting, base.points, start, image, state);
  }
  return found;
}

}  // namespace raylign::photometric
