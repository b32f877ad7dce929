// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/eigen.h"
#include "raylign/camera/camera_model.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/scene/bundle_problem.h"

namespace raylign {

/// A problem as the engines see it, whatever class it came from. The state (cameras, points) is
/// copied, so that it may move; the observations are the problem's own, which must outlive this.
struct BundleScene {
  /// Both validate the problem. Implicit: whatever takes a scene takes a problem.
  BundleScene(const BalProblem& problem);     // NOLINT(google-explicit-constructor)
  BundleScene(const BundleProblem& problem);  // NOLINT(google-explicit-constructor)

  CameraModel camera_model;
  Rows<double, 3> omega;                    ///< (C, 3) angle-axis of R_cw
  Rows<double, 3> t;                        ///< (C, 3) t_cw
  Rows<double, Eigen::Dynamic> intrinsics;  ///< (C, m)
  Rows<double, 3> points;                   ///< (P, 3)
  const Rows<std::int32_t, 1>& camera_index;
  const Rows<std::int32_t, 1>& point_index;
  const Rows<double, 2>& observations;

  std::int64_t num_cameras() const { return omega.rows(); }
  std::int64_t num_points() const { return points.rows(); }
  std::int64_t num_observations() const { return observations.rows(); }
  int num_intrinsics() const { return static_cast<int>(intrinsics.cols()); }

  /// Writes the state into the problem that this was made from; numbers that did not change keep
  /// their bits.
  void store(BalProblem& problem) const;
  void store(BundleProblem& problem) const;
};

/// Optical centres c = −R_cwᵀ t_cw, (C, 3) world frame.
Rows<double, 3> camera_centers(const BundleScene& scene);

/// Predicted minus observed pixel of every observation, (N, 2) px; NaN where the camera cannot
/// project: in its plane, for cameras that look along +z also behind it and beyond the fold of the
/// distortion.
Rows<double, 2> reprojection_residuals(const BundleScene& scene);

/// Distance of every observed point in front of its camera along the viewing axis, (N,) scene
/// units; negative behind.
Rows<double, 1> depths(const BundleScene& scene);

/// ½ Σ ‖r‖² over all observations, px².
double reprojection_cost(const BundleScene& scene);

}  // namespace raylign
