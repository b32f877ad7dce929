// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/depth/depth_model.h"
#include "raylign/tracking/options.h"

namespace raylign {

/// When a tracked frame becomes the next keyframe: (distance_weight ‖t‖ D̄)² + (usage_weight (1 −
/// usage))² > 1, with t the translation from the keyframe, D̄ its mean inverse depth and usage the
/// share of its points in view (LSD-SLAM's program), or when the images agree no more.
struct KeyframeRule {
  double distance_weight = 4.0;  ///< >= 0
  double usage_weight = 3.0;     ///< >= 0
  double min_good_ratio = 0.8;   ///< of the points in view; below it a new keyframe; in [0, 1]
  /// AlignmentResult::agreement below which there is a new keyframe, in [0, 1]. Well above what
  /// AcceptanceOptions asks for: the next frame shall not have to fail first.
  double min_agreement = 0.3;

  void validate() const;
};

/// Where the search for a frame's pose begins, and when a pose is not believed.
struct MotionModelOptions {
  bool constant_velocity = true;  ///< false: begin at the last pose
  /// Starts tried when the first does not lead to an OK alignment: the last pose, and rotations by
  /// this much (rad) about each axis, each way; 0: none.
  double search_rotation = 0.06;
  /// Between two frames, by more than a step of the pose that is not believed: translation as a
  /// share of the mean depth, and rotation (rad); > 0.
  double max_frame_translation = 0.3;
  double max_frame_rotation = 0.5;

  void validate() const;
};

/// Rolling shutter (tracking/shutter.h).
struct ShutterOptions {
  /// From the sequence itself: bent images of a moving camera tell. Stays near zero for a global
  /// shutter.
  bool estimate_readout = true;
  /// s from the first row to the last, or where the estimate begins; 0: global, < 0: from below.
  double readout_s = 0.0;

  void validate() const;
};

struct OdometryOptions {
  TrackingOptions tracking = default_tracking();
  KeyframeOptions keyframe = default_keyframe();
  KeyframeRule keyframe_rule;
  MotionModelOptions motion;
  ShutterOptions shutter;
  DepthModel depth_model = default_depth_model();
  double depth_scale = 1000.0;      ///< units per m of uint16 depth images, > 0
  int num_recovery_keyframes = 10;  ///< a lost frame is compared with as many, newest first; >= 1
  /// An alignment below keyframe_rule.min_agreement is believed only when depth agrees, with or
  /// without the depth term: of the keyframe's points that land where the frame has depth, at least
  /// this share must land on it, within tracking.depth.max_difference; in [0, 1].
  double min_depth_agreement = 0.8;
  /// Without the depth term, a pose is not believed when the frame's depth by itself would move it
  /// by more: share of the mean depth and rad; > 0.
  double max_depth_step = 0.015;

  /// TrackingOptions with a fixed weight of the depth term, 60: on real sequences the weight that
  /// is estimated from single pairs comes out too small and jumps (docs/benchmarks-tracking.md).
  /// Levels end at a change of the cost of 1 %. The agreement asked for is lower than by itself:
  /// where the images leave doubt, min_depth_agreement decides.
  static TrackingOptions default_tracking();
  /// At most 8000 points per level, also where there is little gradient: with depth they count.
  static KeyframeOptions default_keyframe();
  /// Two pixels beside a depth edge are not believed: a point's depth is wanted at its own pixel.
  static DepthModel default_depth_model();
  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

}  // namespace raylign
