// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/options.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign {
namespace {

void require_positive(const char* field, double value) {
  require_option(value > 0.0 && std::isfinite(value), field, "> 0 and finite", value);
}

void require_not_negative(const char* field, double value) {
  require_option(value >= 0.0 && std::isfinite(value), field, ">= 0 and finite", value);
}

}  // namespace

// Every comparison is written so that NaN fails it.
void BrightnessOptions::validate() const {
  require_positive("BrightnessOptions.prior_sigma_a", prior_sigma_a);
  require_positive("BrightnessOptions.prior_sigma_b", prior_sigma_b);
}

void NoiseOptions::validate() const {
  if (loss != LossType::STUDENT_T && loss != LossType::TRIVIAL && loss != LossType::HUBER &&
      loss != LossType::CAUCHY) {
    throw OptionsError("NoiseOptions.loss must be one of trivial, huber, cauchy, student_t, got " +
                       to_string(loss));
  }
  require_not_negative("NoiseOptions.scale", scale);
  require_not_negative("NoiseOptions.nu", nu);
  require_not_negative("NoiseOptions.sensor_sigma", sensor_sigma);
}

void VisibilityOptions::validate() const {
  require_option(max_view_angle > 0.0 && max_view_angle <= 90.0, "VisibilityOptions.max_view_angle",
                 "in (0, 90]", max_view_angle);
  require_option(max_scale_change >= 1.0, "VisibilityOptions.max_scale_change", ">= 1",
                 max_scale_change);
  require_not_negative("VisibilityOptions.occlusion", occlusion);
  require_option(max_residual > 0.0, "VisibilityOptions.max_residual", "> 0", max_residual);
  require_option(min_zncc >= -1.0 && min_zncc <= 1.0, "VisibilityOptions.min_zncc", "in [-1, 1]",
                 min_zncc);
  require_option(!std::isnan(min_grey), "VisibilityOptions.min_grey", "a number", min_grey);
  require_option(max_grey > min_grey, "VisibilityOptions.max_grey", "> min_grey", max_grey);
  require_not_negative("VisibilityOptions.min_texture", min_texture);
  require_option(min_views >= 1, "VisibilityOptions.min_views", ">= 1", min_views);
}

void PhotometricOptions::validate() const {
  if (point_parametrization == PointParametrization::HOMOGENEOUS) {
    throw OptionsError(
        "PhotometricOptions.point_parametrization must be XYZ or INVERSE_DEPTH, got " +
        to_string(point_parametrization));
  }
  pattern.validate();
  constexpr double kWidest = 100.0;  // px: the kernel of the blur is eight times as wide
  require_option(std::isfinite(presmooth) && presmooth <= kWidest, "PhotometricOptions.presmooth",
                 "finite and <= 100 px", presmooth);
  require_option(num_levels >= 0, "PhotometricOptions.num_levels", ">= 0", num_levels);
  brightness.validate();
  noise.validate();
  visibility.validate();
  require_option(max_num_rounds >= 1, "PhotometricOptions.max_num_rounds", ">= 1", max_num_rounds);
  require_option(hold_out == 0 || hold_out >= 2, "PhotometricOptions.hold_out", "0 or >= 2",
                 hold_out);
  require_option(max_leaving_share >= 0.0 && max_leaving_share <= 1.0,
                 "PhotometricOptions.max_leaving_share", "in [0, 1]", max_leaving_share);
  const bool any_depth = std::isinf(min_depth) && min_depth < 0.0;
  require_option(any_depth || (min_depth > 0.0 && std::isfinite(min_depth)),
                 "PhotometricOptions.min_depth", "> 0, or -infinity", min_depth);
  lm.validate();
}

std::string to_string(PatchWarp value) {
  switch (value) {
    case PatchWarp::AUTO:
      return "auto";
    case PatchWarp::NONE:
      return "none";
    case PatchWarp::DEPTH:
      return "depth";
    case PatchWarp::NORMAL:
      return "normal";
  }
  return "unknown";
}

std::string to_string(BrightnessModel value) {
  switch (value) {
    case BrightnessModel::AFFINE:
      return "affine";
    case BrightnessModel::GAIN:
      return "gain";
    case BrightnessModel::NONE:
      return "none";
  }
  return "unknown";
}

std::string to_string(VisibilityRule value) {
  switch (value) {
    case VisibilityRule::AUTO:
      return "auto";
    case VisibilityRule::TRACKS:
      return "tracks";
    case VisibilityRule::ALL:
      return "all";
  }
  return "unknown";
}

std::string to_string(CovarianceScope value) {
  switch (value) {
    case CovarianceScope::NONE:
      return "none";
    case CovarianceScope::POSES:
      return "poses";
    case CovarianceScope::ALL:
      return "all";
  }
  return "unknown";
}

}  // namespace raylign
