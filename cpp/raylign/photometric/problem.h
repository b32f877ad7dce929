// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/image/plane.h"
#include "raylign/image/pyramid.h"
#include "raylign/solver/bundle_config.h"

namespace raylign {

/// Photometric bundle adjustment as arrays: images, cameras and points to refine from grey values.
/// Tables that are optional have no rows when they are not given.
struct PhotometricProblem {
  /// (M,) grey 0..255, linear in irradiance up to e^a I + b. The levels of the pyramids bound the
  /// levels that a solve can use.
  std::vector<std::shared_ptr<const ImagePyramid>> images;
  /// (M,) or empty; null: every pixel counts. Size of the image; 0: the pixel does not count.
  std::vector<std::shared_ptr<const Plane<std::uint8_t>>> masks;
  Rows<double, 4> intrinsics;  ///< (1, 4) of all images, or (M, 4): fx, fy, cx, cy, px
  Rows<double, 16> T_cw;       ///< (M, 16) row-major 4x4
  Rows<double, 3> points;      ///< (N, 3) world frame

  /// (N, n) grey values of stored patches, n pixels of the pattern in its order, or empty: then
  /// each patch is read from its host.
  Rows<float, Eigen::Dynamic> patches;
  /// (N,) image that a patch is read from; −1: its row of `patches` is used. Empty: all −1 when
  /// there are patches, else each point gets the image that sees it best.
  Rows<std::int32_t, 1> hosts;
  /// (N, 2) px of the host image, where the patch is centred. Empty, or a row of NaN: where the
  /// point projects to at the start.
  Rows<double, 2> host_uv;
  Rows<double, 3> normals;  ///< (N, 3) of the surface, in the host's frame; NaN: unknown

  /// (K,) pairs: the images that are said to see a point. Empty: every image may.
  Rows<std::int32_t, 1> track_image;
  Rows<std::int32_t, 1> track_point;

  Rows<double, 2> brightness;  ///< (M, 2) start a, b; empty: estimated

  // Priors around the start, which anchor the gauge: standard covariances, not weights.
  Rows<double, 36> pose_covariances;  ///< (M, 36) of ξ, T_cw = exp(ξ) T_start; NaN: no prior
  Rows<double, 9> point_covariances;  ///< (N, 9) of X, world frame; NaN: no prior
  Rows<double, 1> depth_sigmas;  ///< (N,) standard deviation of z in the host's frame; NaN: none

  std::int64_t num_images() const { return T_cw.rows(); }
  std::int64_t num_points() const { return points.rows(); }
  bool has_patches() const { return patches.rows() > 0; }
  Matrix4 pose(std::int64_t i) const;
  std::int64_t intrinsics_row(std::int64_t image) const {
    return intrinsics.rows() == 1 ? 0 : image;
  }

  /// Throws ShapeError naming the array and the row: lengths that disagree, an index out of range,
  /// a T_cw that is not [R t; 0 1] with a right-handed rotation, a number that is not finite, a
  /// focal length <= 0, a prior that is no covariance.
  /// @param pattern_size  pixels of a patch
  void validate(int pattern_size) const;
};

/// The gauge for a problem whose cameras may all move: FREE where priors of poses or points anchor
/// it, FIRST_CAMERA where priors of depth give the scale, else TWO_CAMERAS.
Gauge default_gauge(const PhotometricProblem& problem);

}  // namespace raylign
