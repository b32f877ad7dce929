// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "raylign/patch/patch_scene.h"

namespace raylign::test {

/// Largest distance between camera centres, scene units.
inline double centre_error(const PatchScene& a, const PatchScene& b) {
  double error = 0.0;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    const Vector3 d =
        a.poses[i].q.conjugate() * a.poses[i].t - b.poses[i].q.conjugate() * b.poses[i].t;
    error = std::max(error, d.norm());
  }
  return error;
}

/// Largest angle between rotations, rad.
inline double rotation_error(const PatchScene& a, const PatchScene& b) {
  double error = 0.0;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    error = std::max(error, quaternion_log(a.poses[i].q * b.poses[i].q.conjugate()).norm());
  }
  return error;
}

/// Largest distance between points, scene units.
inline double point_error(const PatchScene& a, const PatchScene& b) {
  double error = 0.0;
  for (std::int64_t p = 0; p < a.num_points(); ++p) {
    error = std::max(error, (world_point(a, p) - world_point(b, p)).norm());
  }
  return error;
}

}  // namespace raylign::test
