// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

namespace raylign {

/// Rolling shutter: a frame's rows are read one after the other while the camera moves. Row v of h
/// is seen s · readout_s after the pose of its frame, s = (v + 1/2) / h − 1/2; moving with the
/// twist ξ per second, the camera is then at exp(s · readout_s · ξ) T_cw.
struct Shutter {
  double readout_s = 0.0;   ///< first to last row; 0: global shutter, < 0: read from below
  bool has_motion = false;  ///< false: what follows is not known, and no row is moved
  Vector6 host_velocity = Vector6::Zero();  ///< ξ of the keyframe
  /// The target's ξ is its mean velocity since the camera was here, `elapsed_s` before.
  Matrix4 T_before_h = Matrix4::Identity();
  double elapsed_s = 0.0;

  Vector6 target_velocity(const Matrix4& T_th) const;
};

/// What an alignment tells about readout_s: ½ information · Δ² + gradient · Δ is the change of its
/// cost with readout_s + Δ, once pose and brightness have followed.
struct ReadoutEquation {
  double information = 0.0;
  double gradient = 0.0;
};

}  // namespace raylign
