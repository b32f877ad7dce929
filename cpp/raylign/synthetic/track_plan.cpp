// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/track_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "raylign/base/error.h"

namespace raylign {
namespace {

constexpr int kMaxAttempts = 5000;
constexpr std::int64_t kNumCalibrationPoints = 2048;
constexpr double kMaxTailMean = 1e6;

int drawn_length(double tail_mean, double draw) {
  const double tail = std::floor(tail_mean * draw);
  return static_cast<int>(std::min<double>(2.0 + tail, TrackSampler::kMaxTrackLength));
}

// First attempt at point j that two cameras see; its track stays in `track`.
int find_point(TrackSampler& sampler, std::int64_t j, int limit, std::vector<std::int32_t>& track) {
  ScenePoint point;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    if (!sampler.sample(j, attempt, point)) continue;
    sampler.walk(j, attempt, point, limit, track);
    if (track.size() >= 2) return attempt;
  }
  throw OptionsError(
      "BalOptions: camera " + std::to_string(sampler.reference_camera(j)) +
      " shares no surface with an earlier camera: the camera graph would fall apart. Use "
      "more cameras, a smaller stop_spacing, a shorter focal or a larger max_distance");
}

struct Calibration {
  std::vector<double> draws;
  std::vector<int> available;  // cameras that see the point

  double mean_length(double tail_mean) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < draws.size(); ++i) {
      sum += std::min(drawn_length(tail_mean, draws[i]), available[i]);
    }
    return sum / static_cast<double>(draws.size());
  }

  // Relative standard error of the mean over all points, for the margin.
  double spread(double tail_mean) const {
    const double mean = mean_length(tail_mean);
    double sum = 0.0;
    for (std::size_t i = 0; i < draws.size(); ++i) {
      const double d = std::min(drawn_length(tail_mean, draws[i]), available[i]) - mean;
      sum += d * d;
    }
    return std::sqrt(sum) / static_cast<double>(draws.size()) / mean;
  }
};

Calibration calibrate(TrackSampler& sampler, std::int64_t num_points) {
  Calibration calibration;
  std::vector<std::int32_t> track;
  const std::int64_t count = std::min(num_points, kNumCalibrationPoints);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t j = i * num_points / count;
    find_point(sampler, j, TrackSampler::kMaxTrackLength, track);
    calibration.draws.push_back(sampler.tail_draw(j));
    calibration.available.push_back(static_cast<int>(track.size()));
  }
  return calibration;
}

// Mean λ of the tail for which a sample of points reaches the wanted mean length; monotone, by
// bisection.
double solve_tail_mean(const Calibration& calibration, double wanted) {
  if (calibration.mean_length(kMaxTailMean) <= wanted) return kMaxTailMean;
  double low = 0.0;
  double high = kMaxTailMean;
  for (int i = 0; i < 100; ++i) {
    const double middle = low > 0.0 ? std::sqrt(low * high) : 1e-6;
    (calibration.mean_length(middle) < wanted ? low : high) = middle;
    if (low > 0.0 && high < low * (1.0 + 1e-9)) break;
  }
  return high;
}

// Shrinks the part of every track beyond two by one factor; rounding the running total makes the
// sum exact.
void trim(TrackPlan& plan, std::int64_t total, std::int64_t wanted) {
  const auto num_points = static_cast<std::int64_t>(plan.length.size());
  const std::int64_t excess = total - 2 * num_points;
  const std::int64_t wanted_excess = wanted - 2 * num_points;
  if (excess == 0) return;
  const double scale = static_cast<double>(wanted_excess) / static_cast<double>(excess);
  std::int64_t running = 0;
  std::int64_t given = 0;
  for (std::uint16_t& length : plan.length) {
    running += length - 2;
    const auto target = running == excess
                            ? wanted_excess
                            : static_cast<std::int64_t>(scale * static_cast<double>(running));
    length = static_cast<std::uint16_t>(2 + (target - given));
    given = target;
  }
}

}  // namespace

TrackPlan plan_tracks(const SyntheticBalOptions& options, TrackSampler& sampler) {
  const std::int64_t num_points = options.num_points;
  const bool exact = options.num_observations > 0;
  const auto wanted = exact ? options.num_observations
                            : static_cast<std::int64_t>(std::floor(
                                  options.mean_track_length * static_cast<double>(num_points)));
  const Calibration calibration = calibrate(sampler, num_points);
  const double mean = static_cast<double>(wanted) / static_cast<double>(num_points);
  // Aim above the goal by four standard errors of the sample, then trim.
  const double margin = 1.02 + 4.0 * calibration.spread(solve_tail_mean(calibration, mean));
  const double tail_mean = solve_tail_mean(calibration, mean * margin);

  TrackPlan plan;
  plan.attempt.resize(num_points);
  plan.length.resize(num_points);
  std::int64_t total = 0;
  std::vector<std::int32_t> track;
  for (std::int64_t j = 0; j < num_points; ++j) {
    const int limit = drawn_length(tail_mean, sampler.tail_draw(j));
    plan.attempt[j] = static_cast<std::uint16_t>(find_point(sampler, j, limit, track));
    plan.length[j] = static_cast<std::uint16_t>(track.size());
    total += plan.length[j];
  }
  if (exact && total < wanted) {
    throw OptionsError("BalOptions.num_observations must be <= " + std::to_string(total) +
                       ", all that the cameras of this scene see, got " + std::to_string(wanted));
  }
  plan.num_observations = std::min(total, wanted);
  trim(plan, total, plan.num_observations);
  return plan;
}

}  // namespace raylign
