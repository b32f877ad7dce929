// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/options.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign {
namespace {

void require_positive(const char* field, double value) {
  require_option(value > 0.0 && std::isfinite(value), field, "> 0 and finite", value);
}

void require_share(const char* field, double value) {
  require_option(value >= 0.0 && value <= 1.0, field, "in [0, 1]", value);
}

}  // namespace

// Every comparison is written so that NaN fails it.
void AffineOptions::validate() const {
  require_positive("AffineOptions.prior_sigma_a", prior_sigma_a);
  require_positive("AffineOptions.prior_sigma_b", prior_sigma_b);
}

void DepthTermOptions::validate() const {
  require_option(weight >= 0.0 && std::isfinite(weight), "DepthTermOptions.weight",
                 ">= 0 and finite", weight);
  require_option(max_difference > 0.0, "DepthTermOptions.max_difference", "> 0", max_difference);
}

void AcceptanceOptions::validate() const {
  require_option(min_points >= 1, "AcceptanceOptions.min_points", ">= 1", min_points);
  require_share("AcceptanceOptions.min_overlap", min_overlap);
  require_share("AcceptanceOptions.min_good_ratio", min_good_ratio);
  require_share("AcceptanceOptions.min_agreement", min_agreement);
  require_positive("AcceptanceOptions.max_translation", max_translation);
  require_positive("AcceptanceOptions.max_rotation", max_rotation);
  require_positive("AcceptanceOptions.max_sigma", max_sigma);
}

LmOptions TrackingOptions::default_lm() {
  LmOptions lm;
  lm.max_num_iterations = 30;
  lm.function_tolerance = 1e-3;
  lm.parameter_tolerance = 1e-5;
  lm.initial_lambda = 1e-6;
  return lm;
}

int TrackingOptions::max_iterations(int level) const {
  const auto l = static_cast<std::size_t>(level);
  return l < level_iterations.size() ? level_iterations[l] : lm.max_num_iterations;
}

void TrackingOptions::validate() const {
  require_positive("TrackingOptions.sigma_intensity", sigma_intensity);
  require_positive("TrackingOptions.min_sigma_intensity", min_sigma_intensity);
  loss.validate();
  affine.validate();
  depth.validate();
  require_option(motion != MotionGroup::SIM3 || depth.enabled, "DepthTermOptions.enabled",
                 "true for MotionGroup.SIM3", depth.enabled);
  require_option(finest_level >= 0, "TrackingOptions.finest_level", ">= 0", finest_level);
  require_option(coarsest_level >= finest_level && coarsest_level <= 30,
                 "TrackingOptions.coarsest_level", ">= finest_level and <= 30", coarsest_level);
  for (const int n : level_iterations) {
    require_option(n >= 0, "TrackingOptions.level_iterations", ">= 0", n);
  }
  lm.validate();
  acceptance.validate();
}

void KeyframeOptions::validate() const {
  require_option(min_gradient >= 0.0 && std::isfinite(min_gradient), "KeyframeOptions.min_gradient",
                 ">= 0 and finite", min_gradient);
  require_option(max_points >= 0, "KeyframeOptions.max_points", ">= 0", max_points);
  require_option(spacing >= 1, "KeyframeOptions.spacing", ">= 1", spacing);
  require_option(block_size >= 4 && block_size <= 256 && block_size % 2 == 0,
                 "KeyframeOptions.block_size", "an even number in [4, 256]", block_size);
}

std::string to_string(NoiseModel value) {
  return value == NoiseModel::EXACT ? "exact" : "constant";
}

std::string to_string(SigmaMode value) {
  return value == SigmaMode::FROZEN ? "frozen" : "reevaluate";
}

std::string to_string(GradientMode value) { return value == GradientMode::ESM ? "esm" : "forward"; }

std::string to_string(AffineMode value) {
  switch (value) {
    case AffineMode::NONE:
      return "none";
    case AffineMode::CLOSED_FORM:
      return "closed_form";
    case AffineMode::JOINT:
      return "joint";
  }
  return "unknown";
}

std::string to_string(MotionGroup value) {
  switch (value) {
    case MotionGroup::SE3:
      return "se3";
    case MotionGroup::SO3:
      return "so3";
    case MotionGroup::SIM3:
      return "sim3";
  }
  return "unknown";
}

}  // namespace raylign
