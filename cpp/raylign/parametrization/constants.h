// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raylign/parametrization/pose_update.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/solver/bundle_config.h"

namespace raylign {

using CoordinateMask = std::array<bool, 3>;

inline bool all_held(const CoordinateMask& mask) { return mask[0] && mask[1] && mask[2]; }

/// BundleConfig and gauge spelled out per camera and point.
struct Constants {
  std::vector<PoseMask> poses;             ///< (C,)
  std::vector<CoordinateMask> intrinsics;  ///< (C,)
  std::vector<CoordinateMask> points;      ///< (P,), or empty when no point is held

  bool holds_point(std::int64_t p) const { return !points.empty() && all_held(points[p]); }
};

/// Cameras without observations do not serve as gauge cameras.
Constants resolve_constants(const BalProblem& problem, const BundleConfig& config);

}  // namespace raylign
