// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/odometry/options.h"

namespace raylign {

/// Predicts the next camera pose from the last two. Poses are T_cw.
class MotionModel {
 public:
  explicit MotionModel(const MotionModelOptions& options) : options_(options) {}

  /// The pose of the frame at time `timestamp` (s), as a continuation of the last step.
  Matrix4 predict(double timestamp) const;
  /// Poses to try when `predict` did not lead to the frame: the last pose, then rotations of the
  /// prediction about each axis.
  std::vector<Matrix4> alternatives(double timestamp) const;
  /// `T_cw` turned by search_rotation about each axis, each way.
  std::vector<Matrix4> turned(const Matrix4& T_cw) const;
  /// The last pose that was given to `update`.
  const Matrix4& last() const { return T_last_; }
  bool has_last() const { return has_last_; }
  double last_timestamp() const { return last_s_; }
  /// The last step per s, a left twist of T_cw; zero when it is not known.
  Vector6 velocity() const;
  bool has_velocity() const { return step_s_ > 0.0; }

  /// Takes the pose of a tracked frame; `after_loss`: it does not continue the one before, so it
  /// says nothing about velocity.
  void update(const Matrix4& T_cw, double timestamp, bool after_loss);
  /// False when the step from the last pose is larger than the options believe.
  bool is_plausible(const Matrix4& T_cw, double mean_inverse_depth) const;

 private:
  MotionModelOptions options_;
  Matrix4 T_last_ = Matrix4::Identity();
  Vector6 velocity_ = Vector6::Zero();  ///< per `step_s_`
  double last_s_ = 0.0;
  double step_s_ = 0.0;
  bool has_last_ = false;
};

}  // namespace raylign
