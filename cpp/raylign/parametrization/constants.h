// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "raylign/parametrization/pose_update.h"
#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"

namespace raylign {

using CoordinateMask = std::array<bool, 3>;
/// In the order of the camera's parameters; those that the model does not have count as held.
using IntrinsicsMask = std::array<bool, kMaxCameraParams>;

template <std::size_t N>
bool all_held(const std::array<bool, N>& mask) {
  return std::all_of(mask.begin(), mask.end(), [](bool held) { return held; });
}
template <std::size_t N>
int count_free(const std::array<bool, N>& mask) {
  return static_cast<int>(std::count(mask.begin(), mask.end(), false));
}

/// BundleConfig and gauge spelled out per camera and point.
struct Constants {
  std::vector<PoseMask> poses;             ///< (C,)
  std::vector<IntrinsicsMask> intrinsics;  ///< (C,)
  std::vector<CoordinateMask> points;      ///< (P,), or empty when no point is held

  bool holds_point(std::int64_t p) const { return !points.empty() && all_held(points[p]); }
};

/// Cameras without observations do not serve as gauge cameras.
Constants resolve_constants(const BundleScene& scene, const BundleConfig& config);

/// Throws OptionsError when single coordinates of a point are held and points are not XYZ.
void check_point_constants(const Constants& held, PointParametrization parametrization);

}  // namespace raylign
