// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/bal_stream.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "raylign/base/error.h"
#include "raylign/base/random.h"
#include "raylign/synthetic/bal_scene.h"
#include "raylign/synthetic/track_plan.h"
#include "raylign/synthetic/track_sampler.h"

namespace raylign {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

Vector3 normal3(RandomStream& random) {
  const double x = random.normal();
  const double y = random.normal();
  return Vector3(x, y, random.normal());
}

Eigen::Matrix<double, 1, 9> camera_row(const Vector3& omega,
                                       const Vector3& t_cw,
                                       const std::array<double, 3>& intrinsics) {
  Eigen::Matrix<double, 1, 9> row;
  row << omega.transpose(), t_cw.transpose(), intrinsics[0], intrinsics[1], intrinsics[2];
  return row;
}

Eigen::Matrix<double, 1, 9> perturbed_row(const SyntheticBalOptions& o,
                                          const SceneCamera& camera,
                                          double viewing_distance,
                                          std::uint64_t index) {
  RandomStream rotation(o.seed, "start_rotation", index);
  RandomStream translation(o.seed, "start_translation", index);
  RandomStream calibration(o.seed, "start_calibration", index);
  const Vector3 delta = o.rotation_noise_deg * kDegree * normal3(rotation);
  const Vector3 shift = o.translation_noise * viewing_distance * normal3(translation);
  Vector3 omega = camera.omega;
  Vector3 t_cw = camera.t_cw;
  if (!delta.isZero(0.0)) {
    const Matrix3 R_cw = portable_so3_exp(delta) * camera.R_cw;
    omega = portable_so3_log(R_cw);
    t_cw = -(R_cw * camera.center);
  }
  if (!shift.isZero(0.0)) t_cw -= portable_so3_exp(omega) * shift;
  std::array<double, 3> intrinsics = camera.intrinsics;
  const double focal_draw = std::clamp(calibration.normal(), -3.0, 3.0);  // keeps f > 0
  intrinsics[0] *= 1.0 + o.focal_noise * focal_draw;
  intrinsics[1] *= 1.0 + o.distortion_noise * calibration.normal();
  intrinsics[2] *= 1.0 + o.distortion_noise * calibration.normal();
  return camera_row(omega, t_cw, intrinsics);
}

}  // namespace

struct SyntheticBalStream::State {
  explicit State(const SyntheticBalOptions& o)
      : options(o), scene(make_bal_scene(o)), sampler(o, *scene), plan(plan_tracks(o, sampler)) {}

  void append_observations(std::int64_t j, SyntheticObservationChunk& chunk);
  Vector3 start_point(std::int64_t j, const ScenePoint& point) const;

  const SyntheticBalOptions options;
  const std::unique_ptr<BalScene> scene;
  TrackSampler sampler;
  const TrackPlan plan;
  std::int64_t next_observed_point = 0;
  std::int64_t next_point = 0;
  std::vector<std::int32_t> track;
};

void SyntheticBalStream::State::append_observations(std::int64_t j,
                                                    SyntheticObservationChunk& chunk) {
  ScenePoint point;
  sampler.sample(j, plan.attempt[j], point);
  sampler.walk(j, plan.attempt[j], point, plan.length[j], track);
  std::sort(track.begin(), track.end());
  RandomStream noise(options.seed, "pixel_noise", j);
  RandomStream outlier(options.seed, "outlier", j);
  for (const std::int32_t camera : track) {
    const double du = options.pixel_noise * noise.normal();
    const double dv = options.pixel_noise * noise.normal();
    const bool is_inlier = !(outlier.uniform() < options.outlier_fraction);
    const double u = options.image_width * (outlier.uniform() - 0.5);
    const double v = options.image_height * (outlier.uniform() - 0.5);
    chunk.camera_index.push_back(camera);
    chunk.point_index.push_back(static_cast<std::int32_t>(j));
    chunk.observations.push_back(
        is_inlier ? Vector2(sampler.project(camera, point.position) + Vector2(du, dv))
                  : Vector2(u, v));
    chunk.inlier.push_back(is_inlier ? 1 : 0);
  }
}

Vector3 SyntheticBalStream::State::start_point(std::int64_t j, const ScenePoint& point) const {
  const Vector3& center = scene->cameras()[sampler.reference_camera(j)].center;
  RandomStream random(options.seed, "start_point", j);
  return point.position + options.point_noise * (point.position - center).norm() * normal3(random);
}

SyntheticBalStream::SyntheticBalStream(const SyntheticBalOptions& options)
    : state_(std::make_unique<State>(options)) {}
SyntheticBalStream::~SyntheticBalStream() = default;
SyntheticBalStream::SyntheticBalStream(SyntheticBalStream&&) noexcept = default;
SyntheticBalStream& SyntheticBalStream::operator=(SyntheticBalStream&&) noexcept = default;

const SyntheticBalOptions& SyntheticBalStream::options() const { return state_->options; }
std::int64_t SyntheticBalStream::num_observations() const { return state_->plan.num_observations; }

Rows<double, 9> SyntheticBalStream::true_cameras() const {
  const std::vector<SceneCamera>& cameras = state_->scene->cameras();
  Rows<double, 9> rows(static_cast<Eigen::Index>(cameras.size()), 9);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    rows.row(i) = camera_row(cameras[i].omega, cameras[i].t_cw, cameras[i].intrinsics);
  }
  return rows;
}

Rows<double, 9> SyntheticBalStream::start_cameras() const {
  const std::vector<SceneCamera>& cameras = state_->scene->cameras();
  Rows<double, 9> rows(static_cast<Eigen::Index>(cameras.size()), 9);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    rows.row(i) = perturbed_row(state_->options, cameras[i], state_->scene->viewing_distance(), i);
  }
  return rows;
}

bool SyntheticBalStream::next_observations(std::int64_t max_points,
                                           SyntheticObservationChunk& chunk) {
  chunk.camera_index.clear();
  chunk.point_index.clear();
  chunk.observations.clear();
  chunk.inlier.clear();
  std::int64_t& next = state_->next_observed_point;
  const std::int64_t end = std::min(state_->options.num_points, next + max_points);
  for (; next < end; ++next) state_->append_observations(next, chunk);
  return !chunk.observations.empty();
}

bool SyntheticBalStream::next_points(std::int64_t max_points, SyntheticPointChunk& chunk) {
  chunk.truth.clear();
  chunk.start.clear();
  chunk.colors.clear();
  std::int64_t& next = state_->next_point;
  const std::int64_t end = std::min(state_->options.num_points, next + max_points);
  for (; next < end; ++next) {
    ScenePoint point;
    state_->sampler.sample(next, state_->plan.attempt[next], point);
    chunk.truth.push_back(point.position);
    chunk.start.push_back(state_->start_point(next, point));
    chunk.colors.insert(chunk.colors.end(), point.color.begin(), point.color.end());
  }
  return !chunk.truth.empty();
}

}  // namespace raylign
