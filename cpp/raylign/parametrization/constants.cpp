// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/parametrization/constants.h"

#include "raylign/base/error.h"
#include "raylign/geometry/so3.h"

namespace raylign {
namespace {

constexpr int kRotation = 3;  // coordinate_offset(POSE, "rotation")

void hold_pose(PoseMask& mask) {
  mask.translation.fill(true);
  mask.rotation = true;
}

// Calls apply(i) for one index or, with kAll, for every index below count.
template <typename Apply>
void for_each_index(std::int32_t index, std::int64_t count, const Apply& apply) {
  if (index != ConstantCoordinate::kAll) return apply(index);
  for (std::int64_t i = 0; i < count; ++i) apply(i);
}

void hold_coordinate(const ConstantCoordinate& constant,
                     const BundleScene& scene,
                     Constants& held) {
  const int offset =
      coordinate_offset(constant.kind, constant.coordinate, param_names(scene.camera_model));
  switch (constant.kind) {
    case ParameterKind::POSE:
      for_each_index(constant.index, scene.num_cameras(), [&](std::int64_t i) {
        if (offset == kRotation)
          held.poses[i].rotation = true;
        else
          held.poses[i].translation[offset] = true;
      });
      break;
    case ParameterKind::INTRINSICS:
      for_each_index(constant.index, scene.num_cameras(),
                     [&](std::int64_t i) { held.intrinsics[i][offset] = true; });
      break;
    case ParameterKind::POINT:
      held.points.resize(scene.num_points(), CoordinateMask{});
      for_each_index(constant.index, scene.num_points(),
                     [&](std::int64_t i) { held.points[i][offset] = true; });
      break;
  }
}

// t of camera i as seen from camera 0's centre: R_i (c_i − c_0), up to sign. A change of scale
// about c_0 moves t_i along this vector, so its largest coordinate is the one to hold (COLMAP's
// rule).
Vector3 baseline(const BundleScene& scene, std::int64_t i, std::int64_t first) {
  const auto pose = [&](std::int64_t k) {
    const Vector3 omega = scene.omega.row(k).transpose();
    return std::pair<Matrix3, Vector3>(so3_exp(omega), scene.t.row(k).transpose());
  };
  const auto [R_0, t_0] = pose(first);
  const auto [R_i, t_i] = pose(i);
  return t_i - R_i * (R_0.transpose() * t_0);
}

void hold_gauge(const BundleScene& scene, Gauge gauge, Constants& held) {
  if (gauge == Gauge::FREE || scene.num_observations() == 0) return;
  std::vector<bool> observed(scene.num_cameras(), false);
  for (std::int64_t i = 0; i < scene.num_observations(); ++i)
    observed[scene.camera_index[i]] = true;
  std::int64_t first = 0;
  while (!observed[first]) ++first;
  hold_pose(held.poses[first]);
  if (gauge == Gauge::FIRST_CAMERA) return;

  std::int64_t farthest = -1;
  double longest = 0.0;
  for (std::int64_t i = first + 1; i < scene.num_cameras(); ++i) {
    const double length = observed[i] ? baseline(scene, i, first).norm() : 0.0;
    if (length > longest) {
      longest = length;
      farthest = i;
    }
  }
  if (farthest < 0) return;  // a single viewpoint has no scale to hold
  Eigen::Index coordinate = 0;
  baseline(scene, farthest, first).cwiseAbs().maxCoeff(&coordinate);
  held.poses[farthest].translation[coordinate] = true;
}

}  // namespace

Constants resolve_constants(const BundleScene& scene, const BundleConfig& config) {
  Constants held;
  held.poses.resize(scene.num_cameras());
  IntrinsicsMask absent{};
  std::fill(absent.begin() + scene.num_intrinsics(), absent.end(), true);
  held.intrinsics.resize(scene.num_cameras(), absent);
  for (const std::int32_t i : config.constant_cameras) hold_pose(held.poses[i]);
  for (const std::int32_t i : config.constant_intrinsics) held.intrinsics[i].fill(true);
  if (!config.constant_points.empty()) held.points.resize(scene.num_points(), CoordinateMask{});
  for (const std::int32_t i : config.constant_points) held.points[i].fill(true);
  for (const ConstantCoordinate& constant : config.constant_coordinates) {
    hold_coordinate(constant, scene, held);
  }
  hold_gauge(scene, config.gauge, held);
  return held;
}

void check_point_constants(const Constants& held, PointParametrization parametrization) {
  if (parametrization == PointParametrization::XYZ) return;
  for (const CoordinateMask& mask : held.points) {
    if (all_held(mask) || count_free(mask) == 3) continue;
    throw OptionsError(
        "BundleConfig.constant_coordinates holds single coordinates of a point, which "
        "needs point_parametrization XYZ, got " +
        to_string(parametrization));
  }
}

}  // namespace raylign
