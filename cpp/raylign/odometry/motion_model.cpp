// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/motion_model.h"

#include <algorithm>
#include <cmath>

#include "raylign/geometry/se3.h"
#include "raylign/geometry/so3.h"

namespace raylign {
namespace {

// Over a gap of many frames the last step is no prediction any more.
constexpr double kMaxExtrapolation = 2.0;

}  // namespace

Matrix4 MotionModel::predict(double timestamp) const {
  if (!options_.constant_velocity || !(step_s_ > 0.0)) return T_last_;
  const double steps = std::clamp((timestamp - last_s_) / step_s_, 0.0, kMaxExtrapolation);
  return se3_exp(steps * velocity_) * T_last_;
}

Vector6 MotionModel::velocity() const {
  return has_velocity() ? Vector6(velocity_ / step_s_) : Vector6(Vector6::Zero());
}

std::vector<Matrix4> MotionModel::alternatives(double timestamp) const {
  std::vector<Matrix4> starts;
  if (options_.constant_velocity) starts.push_back(T_last_);
  for (const Matrix4& T_cw : turned(predict(timestamp))) starts.push_back(T_cw);
  return starts;
}

std::vector<Matrix4> MotionModel::turned(const Matrix4& T_cw) const {
  std::vector<Matrix4> starts;
  if (options_.search_rotation == 0.0) return starts;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector6 xi = Vector6::Zero();
      xi[3 + axis] = sign * options_.search_rotation;
      starts.push_back(se3_exp(xi) * T_cw);
    }
  }
  return starts;
}

void MotionModel::update(const Matrix4& T_cw, double timestamp, bool after_loss) {
  const double elapsed_s = timestamp - last_s_;
  if (has_last_ && !after_loss && elapsed_s > 0.0) {
    velocity_ = se3_log(T_cw * se3_inverse(T_last_));
    step_s_ = elapsed_s;
  } else {
    velocity_.setZero();
    step_s_ = 0.0;
  }
  T_last_ = T_cw;
  last_s_ = timestamp;
  has_last_ = true;
}

bool MotionModel::is_plausible(const Matrix4& T_cw, double mean_inverse_depth) const {
  const Matrix4 step = T_cw * se3_inverse(T_last_);
  const double translation = step.topRightCorner<3, 1>().norm() * mean_inverse_depth;
  const double rotation = so3_log(step.topLeftCorner<3, 3>()).norm();
  return translation <= options_.max_frame_translation && rotation <= options_.max_frame_rotation;
}

}  // namespace raylign
