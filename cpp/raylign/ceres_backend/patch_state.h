// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/patch/patch_scene.h"

namespace raylign::ceres_backend {

/// The numbers of a PatchScene that Ceres moves: image by image pose [q (xyzw), t] and brightness,
/// then rows of intrinsics, then points. In one buffer for the reason given at ParameterState.
class PatchState {
 public:
  explicit PatchState(const PatchScene& scene);
  PatchState(const PatchState&) = delete;  // Ceres keeps the addresses
  PatchState& operator=(const PatchState&) = delete;

  double* pose(std::int64_t i) { return values_.data() + kImageSize * i; }
  double* brightness(std::int64_t i) { return pose(i) + kPoseSize; }
  double* intrinsics(std::int64_t row) { return values_.data() + intrinsics_ + 4 * row; }
  double* point(std::int64_t p) { return values_.data() + points_ + point_size_ * p; }
  int point_size() const { return point_size_; }

  void save() { saved_ = values_; }
  void restore_saved() { values_ = saved_; }
  /// Every number as it stands.
  void write(PatchScene& scene) const;

 private:
  static constexpr std::int64_t kPoseSize = 7;
  static constexpr std::int64_t kImageSize = kPoseSize + 2;

  std::int64_t intrinsics_, points_;  // offsets
  int point_size_;
  std::vector<double> values_, saved_;
};

}  // namespace raylign::ceres_backend
