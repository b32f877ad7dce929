// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/camera/pinhole.h"
#include "raylign/camera/radtan.h"

namespace raylign {

/// Where each pixel of a new pinhole image lies in the image of a camera; (height, width), px,
/// float32 as image/remap.h wants it. Pixels whose ray the camera does not image hold kOutside in
/// both maps.
struct UndistortMap {
  static constexpr float kOutside = -1e4f;  ///< far enough outside for every interpolation kernel

  Rows<float, Eigen::Dynamic> map_x;
  Rows<float, Eigen::Dynamic> map_y;
};

/// Map from the pinhole image (K_new, width x height) to the image of `camera`, as OpenCV's
/// initUndistortRectifyMap with R = I. K_new may be any invertible upper-triangular 3x3 matrix.
/// Throws ShapeError for a size < 1, OptionsError for a K_new that is singular or not finite.
UndistortMap undistort_map(const PinholeCamera& camera,
                           const Matrix3& K_new,
                           int width,
                           int height);
UndistortMap undistort_map(const RadtanCamera& camera, const Matrix3& K_new, int width, int height);

}  // namespace raylign
