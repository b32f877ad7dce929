// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/eigen.h"
#include "raylign/camera/camera_model.h"
#include "raylign/scene/bal_problem.h"

namespace raylign {

/// A reprojection problem with cameras of one model: poses as 4x4 matrices, each camera with its
/// own intrinsics. BalProblem is the special case that has a file format.
struct BundleProblem {
  CameraModel camera_model = CameraModel::PINHOLE;
  Rows<double, 16> T_cw;  ///< (C, 16) row-major 4x4: p_c = T_cw p_w, axes of the camera model
  Rows<double, Eigen::Dynamic> intrinsics;  ///< (C, num_params(camera_model)), its order
  Rows<double, 3> points;                   ///< (P, 3) world frame, scene units
  Rows<std::int32_t, 1> camera_index;       ///< (N,) in [0, C)
  Rows<std::int32_t, 1> point_index;        ///< (N,) in [0, P)
  Rows<double, 2> observations;             ///< (N, 2) pixels of the camera model
  Rows<std::uint8_t, 3> colors;             ///< (P, 3) RGB, or (0, 3) when unknown

  std::int64_t num_cameras() const { return T_cw.rows(); }
  std::int64_t num_points() const { return points.rows(); }
  std::int64_t num_observations() const { return observations.rows(); }

  /// T_cw of camera i, 4x4.
  Matrix4 pose(std::int64_t i) const;

  /// Throws ShapeError when lengths disagree, a table has more than 2³¹ − 1 rows, an index is out
  /// of range or a T_cw is not [R t; 0 1] with R a rotation (check_rigid). Intrinsics,
  /// points and pixels are not looked at: a NaN is the business of whoever computes with it.
  void validate() const;
};

/// Bitwise equality of every array, and the same model.
bool operator==(const BundleProblem& a, const BundleProblem& b);
bool operator!=(const BundleProblem& a, const BundleProblem& b);

/// The same problem as a BundleProblem. BAL keeps the file's axes and numbers. RADTAN and PINHOLE
/// turn the cameras by diag(1, −1, −1), so that they look along +z with v down, and negate v of
/// each pixel: the same cost, fx = fy = f, the principal point at pixel (0, 0). Throws OptionsError
/// for PINHOLE when a camera has distortion.
BundleProblem to_bundle_problem(const BalProblem& problem, CameraModel model);

/// The way back: exact for model BAL; else the principal point is subtracted from the pixels.
/// Throws OptionsError when a camera is none that BAL can say: fx and fy differ, or p1, p2 or k3 is
/// not zero.
BalProblem to_bal_problem(const BundleProblem& problem);

}  // namespace raylign
