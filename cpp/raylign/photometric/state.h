// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/photometric/problem.h"
#include "raylign/photometric/result.h"

namespace raylign::photometric {

/// Everything that a photometric bundle adjustment moves.
struct PhotometricState {
  std::vector<PatchPose> poses;  ///< (M,)
  Rows<double, 2> brightness;    ///< (M, 2)
  Rows<double, 4> intrinsics;    ///< (1, 4) or (M, 4)
  Rows<double, 3> points;        ///< (N, 3) world frame

  std::int64_t intrinsics_row(std::int64_t image) const {
    return intrinsics.rows() == 1 ? 0 : image;
  }
  Vector3 in_camera(std::int64_t image, const Vector3& X) const {
    return poses[image].q * X + poses[image].t;
  }
  /// K⁻¹ (u, v, 1) of an image.
  Vector3 ray(std::int64_t image, const Vector2& uv) const;
  /// Projection of a point in front of the camera; false when z <= 0.
  bool project(std::int64_t image, const Vector3& X, Vector2& uv) const;
};

/// Brightness zero unless the problem says otherwise.
PhotometricState start_state(const PhotometricProblem& problem);

/// Writes `state` into the result; poses that have not moved from `start` keep the problem's bits.
void store(const PhotometricState& state,
           const PhotometricState& start,
           const PhotometricProblem& problem,
           PhotometricResult& result);

bool same_pose(const PatchPose& a, const PatchPose& b);

}  // namespace raylign::photometric
