// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/bal_options.h"

#include <cmath>
#include <limits>
#include <string>

#include "raylign/base/error.h"

namespace raylign {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

[[noreturn]] void fail(const std::string& field,
                       const std::string& rule,
                       const std::string& value) {
  throw OptionsError("BalOptions." + field + " must be " + rule + ", got " + value);
}

void require_at_least(const char* field, std::int64_t value, std::int64_t low) {
  if (value < low) fail(field, ">= " + std::to_string(low), std::to_string(value));
}

// NaN fails every comparison and therefore the check.
void require_within(const char* field, double value, double low, double high) {
  if (value >= low && value <= high && std::isfinite(value)) return;
  const std::string rule = std::isfinite(high)
                               ? "in [" + format_double(low) + ", " + format_double(high) + "]"
                               : "finite and >= " + format_double(low);
  fail(field, rule, format_double(value));
}

void require_positive(const char* field, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) fail(field, "finite and > 0", format_double(value));
}

void validate_counts(const SyntheticBalOptions& o) {
  constexpr std::int64_t kMaxIndex = std::numeric_limits<std::int32_t>::max();
  require_at_least("num_cameras", o.num_cameras, 2);
  require_at_least("num_points", o.num_points, 4LL * o.num_cameras);
  if (o.num_points > kMaxIndex) fail("num_points", "< 2^31", std::to_string(o.num_points));
  if (o.num_observations != 0) {
    require_at_least("num_observations", o.num_observations, 2 * o.num_points);
    if (o.num_observations / o.num_cameras > o.num_points) {
      fail("num_observations", "<= num_cameras * num_points", std::to_string(o.num_observations));
    }
  }
  require_within("mean_track_length", o.mean_track_length, 2.0, kInfinity);
  require_at_least("num_laps", o.num_laps, 1);
  require_at_least("views_per_stop", o.views_per_stop, 1);
}

// u(r) = r (1 + k1 r² + k2 r⁴) must grow up to the corner, else two directions share one pixel.
void validate_distortion(const SyntheticBalOptions& o) {
  const double k1 = o.k1 - kMaxCameraSigmas * o.k1_sigma;
  const double k2 = o.k2 - kMaxCameraSigmas * o.k2_sigma;
  const double limit = max_squared_radius(o);
  double r2 = limit;
  if (k2 > 0.0 && k1 < 0.0)
    r2 = std::fmin(limit, -0.3 * k1 / k2);  // vertex of 1 + 3 k1 r² + 5 k2 r⁴
  for (const double x : {r2, limit}) {
    if (1.0 + x * (3.0 * k1 + 5.0 * k2 * x) > 0.05) continue;
    throw OptionsError("BalOptions.k1, k2 and their sigmas fold the image over itself: at k1 = " +
                       format_double(k1) + ", k2 = " + format_double(k2) +
                       " the distorted radius stops growing inside the image");
  }
}

void validate_camera(const SyntheticBalOptions& o) {
  require_at_least("image_width", o.image_width, 16);
  require_at_least("image_height", o.image_height, 16);
  require_positive("focal", o.focal);
  require_within("focal_sigma", o.focal_sigma, 0.0, 0.3);
  require_within("k1", o.k1, -kInfinity, kInfinity);
  require_within("k1_sigma", o.k1_sigma, 0.0, kInfinity);
  require_within("k2", o.k2, -kInfinity, kInfinity);
  require_within("k2_sigma", o.k2_sigma, 0.0, kInfinity);
  validate_distortion(o);
}

}  // namespace

double max_squared_radius(const SyntheticBalOptions& o) {
  const double focal = o.focal * (1.0 - kMaxCameraSigmas * o.focal_sigma);
  const double squared_diagonal = static_cast<double>(o.image_width) * o.image_width +
                                  static_cast<double>(o.image_height) * o.image_height;
  return 1.1 * squared_diagonal / (4.0 * focal * focal);
}

void SyntheticBalOptions::validate() const {
  validate_counts(*this);
  validate_camera(*this);
  require_positive("stop_spacing", stop_spacing);
  require_within("loop_closure_fraction", loop_closure_fraction, 0.0, 1.0);
  require_positive("max_distance", max_distance);
  require_within("far_fraction", far_fraction, 0.0, 1.0);
  require_within("far_factor", far_factor, 100.0, 1e9);
  require_within("pixel_noise", pixel_noise, 0.0, kInfinity);
  require_within("outlier_fraction", outlier_fraction, 0.0, 0.999);
  require_within("rotation_noise_deg", rotation_noise_deg, 0.0, 90.0);
  require_within("translation_noise", translation_noise, 0.0, kInfinity);
  require_within("point_noise", point_noise, 0.0, kInfinity);
  require_within("focal_noise", focal_noise, 0.0, 0.3);
  require_within("distortion_noise", distortion_noise, 0.0, kInfinity);
}

}  // namespace raylign
