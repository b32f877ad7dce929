// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/track_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raylign/base/portable_math.h"
#include "raylign/camera/bal.h"

namespace raylign {
namespace {

constexpr double kDetection = 0.75;  // chance that a visible point is matched in one more picture
constexpr double kMinFacingCosine = 0.17;  // flatter than 80° to the surface, nothing is matched
constexpr double kNearestDepth = 0.5;      // m
constexpr double kMaxScaleChange = 3.0;    // between the pictures of one track
constexpr double kMinFarFactor = 100.0;    // baselines
constexpr Rgb kFarColor = {176, 196, 222};

// Points per camera, with ±25 % spread; sums to num_points by rounding the running total.
std::vector<std::int64_t> share_points(const SyntheticBalOptions& options) {
  const int count = options.num_cameras;
  std::vector<double> running(count + 1, 0.0);
  for (int i = 0; i < count; ++i) {
    running[i + 1] = running[i] + RandomStream(options.seed, "camera_share", i).uniform(0.75, 1.25);
  }
  std::vector<std::int64_t> begin(count + 1, 0);
  const double scale = static_cast<double>(options.num_points) / running[count];
  for (int i = 0; i < count; ++i)
    begin[i + 1] = static_cast<std::int64_t>(std::floor(scale * running[i + 1] + 0.5));
  begin[count] = options.num_points;
  return begin;
}

}  // namespace

TrackSampler::TrackSampler(const SyntheticBalOptions& options, const BalScene& scene)
    : options_(options),
      scene_(scene),
      neighbors_(scene, options.max_distance),
      max_squared_radius_(max_squared_radius(options)),
      point_begin_(share_points(options)) {}

int TrackSampler::reference_camera(std::int64_t j) const {
  const auto after = std::upper_bound(point_begin_.begin(), point_begin_.end(), j);
  return static_cast<int>(after - point_begin_.begin()) - 1;
}

bool TrackSampler::is_link(std::int64_t j) const {
  const int camera = reference_camera(j);
  return camera > 0 && j == point_begin_[camera];
}

bool TrackSampler::sample(std::int64_t j, int attempt, ScenePoint& point) const {
  const int camera = reference_camera(j);
  RandomStream random(options_.seed, "point", j, attempt);
  const bool far = options_.far_fraction > 0.0 &&
                   RandomStream(options_.seed, "is_far", j).uniform() < options_.far_fraction;
  const bool drawn = far ? sample_far(camera, random, point) : scene_.sample(camera, random, point);
  return drawn && is_visible(camera, point);
}

// Above the horizon where the picture shows any sky within a few draws; depth log-uniform.
bool TrackSampler::sample_far(int camera, RandomStream& random, ScenePoint& point) const {
  Vector3 direction = Vector3::Zero();
  bool inside = false;
  for (int i = 0; i < 8 && !(inside && direction.z() > 0.0); ++i) {
    inside = sample_direction(options_, scene_.cameras()[camera], random, direction);
  }
  const double span = portable::log(options_.far_factor / kMinFarFactor);
  const double depth = kMinFarFactor * scene_.baseline() * portable::exp(span * random.uniform());
  point = ScenePoint();
  point.position = scene_.cameras()[camera].center + depth * direction;
  point.color = shade(kFarColor, 1.0, random);
  point.reach = std::numeric_limits<double>::infinity();
  return inside;
}

bool TrackSampler::is_visible(int camera, const ScenePoint& point) const {
  const SceneCamera& c = scene_.cameras()[camera];
  const Vector3 way = c.center - point.position;
  const double squared_distance = way.squaredNorm();
  if (squared_distance > point.reach * point.reach) return false;
  const bool one_sided = !point.normal.isZero(0.0);
  const double facing = point.normal.dot(way);
  if (one_sided &&
      (facing <= 0.0 || facing * facing < kMinFacingCosine * kMinFacingCosine * squared_distance)) {
    return false;
  }
  const Vector3 p_c = c.R_cw * point.position + c.t_cw;
  if (p_c.z() > -kNearestDepth) return false;
  // Beyond this radius the distortion polynomial may fold points back into the picture.
  if (p_c.head<2>().squaredNorm() > max_squared_radius_ * p_c.z() * p_c.z()) return false;
  double uv[2];
  bal_project(c.intrinsics.data(), p_c.data(), uv);
  if (std::abs(uv[0]) > 0.5 * options_.image_width || std::abs(uv[1]) > 0.5 * options_.image_height)
    return false;
  return std::isinf(point.reach) || scene_.line_of_sight(camera, point);
}

Vector2 TrackSampler::project(int camera, const Vector3& p_w) const {
  const SceneCamera& c = scene_.cameras()[camera];
  const Vector3 p_c = c.R_cw * p_w + c.t_cw;
  Vector2 uv;
  bal_project(c.intrinsics.data(), p_c.data(), uv.data());
  return uv;
}

double TrackSampler::tail_draw(std::int64_t j) const {
  // Lomax with shape 2 by inversion: only a square root, so the same bits everywhere.
  return 1.0 / std::sqrt(1.0 - RandomStream(options_.seed, "track_length", j).uniform()) - 1.0;
}

void TrackSampler::load_neighbors(int camera) {
  if (camera == cached_camera_) return;
  neighbors_.query(camera, cached_neighbors_);
  cached_camera_ = camera;
}

// The best neighbour with a lower index; the camera just before, where neighbours crowd too
// densely.
std::int32_t TrackSampler::find_earlier(int camera, const ScenePoint& point) {
  for (std::size_t i = 0; i < cached_neighbors_.size(); ++i) {
    const std::int32_t other = cached_neighbors_[i];
    if (other < camera && is_visible(other, point)) return other;
  }
  return is_visible(camera - 1, point) ? camera - 1 : -1;
}

void TrackSampler::walk(std::int64_t j,
                        int attempt,
                        const ScenePoint& point,
                        int limit,
                        std::vector<std::int32_t>& track) {
  const int reference = reference_camera(j);
  load_neighbors(reference);
  track.assign(1, reference);
  const std::int32_t partner = is_link(j) ? find_earlier(reference, point) : -1;
  if (is_link(j) && partner < 0) return;
  if (partner >= 0) track.push_back(partner);
  RandomStream random(options_.seed, "track", j, attempt);
  const bool every_lap = random.uniform() < options_.loop_closure_fraction;
  const int lap = scene_.cameras()[reference].lap;
  const double squared_distance =
      (scene_.cameras()[reference].center - point.position).squaredNorm();
  constexpr double kMaxSquaredScale = kMaxScaleChange * kMaxScaleChange;
  for (std::size_t i = 0; i < cached_neighbors_.size(); ++i) {
    if (static_cast<int>(track.size()) >= limit) return;
    const std::int32_t other = cached_neighbors_[i];
    const SceneCamera& c = scene_.cameras()[other];
    const bool matched = random.uniform() < kDetection;
    if (!matched || other == partner || (!every_lap && c.lap != lap)) continue;
    const double squared_other = (c.center - point.position).squaredNorm();
    if (squared_other > kMaxSquaredScale * squared_distance) continue;
    if (squared_distance > kMaxSquaredScale * squared_other) continue;
    if (is_visible(other, point)) track.push_back(other);
  }
}

}  // namespace raylign
