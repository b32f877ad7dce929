// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/options.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign {

void KeyframeRule::validate() const {
  require_option(distance_weight >= 0 && std::isfinite(distance_weight),
                 "KeyframeRule.distance_weight", "finite and >= 0", distance_weight);
  require_option(usage_weight >= 0 && std::isfinite(usage_weight), "KeyframeRule.usage_weight",
                 "finite and >= 0", usage_weight);
  require_option(min_good_ratio >= 0 && min_good_ratio <= 1, "KeyframeRule.min_good_ratio",
                 "in [0, 1]", min_good_ratio);
  require_option(min_agreement >= 0 && min_agreement <= 1, "KeyframeRule.min_agreement",
                 "in [0, 1]", min_agreement);
}

void MotionModelOptions::validate() const {
  require_option(search_rotation >= 0 && search_rotation < 1, "MotionModelOptions.search_rotation",
                 "in [0, 1) (rad)", search_rotation);
  require_option(max_frame_translation > 0, "MotionModelOptions.max_frame_translation", "> 0",
                 max_frame_translation);
  require_option(max_frame_rotation > 0, "MotionModelOptions.max_frame_rotation", "> 0 (rad)",
                 max_frame_rotation);
}

void ShutterOptions::validate() const {
  require_option(std::isfinite(readout_s), "ShutterOptions.readout_s", "finite (s)", readout_s);
}

TrackingOptions OdometryOptions::default_tracking() {
  TrackingOptions tracking;
  tracking.depth.estimate_weight = false;
  tracking.depth.weight = 60.0;
  tracking.lm.function_tolerance = 1e-2;
  tracking.acceptance.min_agreement = 0.1;
  return tracking;
}

KeyframeOptions OdometryOptions::default_keyframe() {
  KeyframeOptions keyframe;
  keyframe.min_gradient = 1.0;
  keyframe.max_points = 8000;
  return keyframe;
}

DepthModel OdometryOptions::default_depth_model() {
  DepthModel model;
  model.edge_radius = 2;
  return model;
}

void OdometryOptions::validate() const {
  tracking.validate();
  if (tracking.motion == MotionGroup::SIM3) {
    throw OptionsError("OdometryOptions.tracking.motion must be SE3 or SO3: depth has a scale");
  }
  keyframe.validate();
  keyframe_rule.validate();
  motion.validate();
  shutter.validate();
  depth_model.validate();
  require_option(depth_scale > 0 && std::isfinite(depth_scale), "OdometryOptions.depth_scale",
                 "finite and > 0 (units per m)", depth_scale);
  require_option(num_recovery_keyframes >= 1, "OdometryOptions.num_recovery_keyframes", ">= 1",
                 num_recovery_keyframes);
  require_option(min_depth_agreement >= 0 && min_depth_agreement <= 1,
                 "OdometryOptions.min_depth_agreement", "in [0, 1]", min_depth_agreement);
  require_option(max_depth_step > 0, "OdometryOptions.max_depth_step", "> 0", max_depth_step);
}

}  // namespace raylign
