// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_state.h"

namespace raylign::ceres_backend {

PatchState::PatchState(const PatchScene& scene)
    : intrinsics_(kImageSize * scene.num_images()),
      points_(intrinsics_ + scene.intrinsics.size()),
      point_size_(scene.inverse_depth ? 1 : 3),
      values_(points_ + point_size_ * scene.num_points()) {
  for (std::int64_t i = 0; i < scene.num_images(); ++i) {
    Eigen::Map<Vector4>{pose(i)} = scene.poses[i].q.coeffs();
    Eigen::Map<Vector3>{pose(i) + 4} = scene.poses[i].t;
    Eigen::Map<Vector2>{brightness(i)} = scene.brightness.row(i).transpose();
  }
  for (std::int64_t row = 0; row < scene.intrinsics.rows(); ++row) {
    Eigen::Map<Vector4>{intrinsics(row)} = scene.intrinsics.row(row).transpose();
  }
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (int k = 0; k < point_size_; ++k) point(p)[k] = scene.points(p, k);
  }
  saved_ = values_;
}

void PatchState::write(PatchScene& scene) const {
  const double* at = values_.data();
  for (std::int64_t i = 0; i < scene.num_images(); ++i, at += kImageSize) {
    scene.poses[i].q.coeffs() = Eigen::Map<const Vector4>(at);
    scene.poses[i].t = Eigen::Map<const Vector3>(at + 4);
    scene.brightness.row(i) = Eigen::Map<const Vector2>(at + kPoseSize).transpose();
  }
  for (std::int64_t row = 0; row < scene.intrinsics.rows(); ++row, at += 4) {
    scene.intrinsics.row(row) = Eigen::Map<const Vector4>(at).transpose();
  }
  for (std::int64_t p = 0; p < scene.num_points(); ++p, at += point_size_) {
    for (int k = 0; k < point_size_; ++k) scene.points(p, k) = at[k];
  }
}

}  // namespace raylign::ceres_backend
