// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/camera/pinhole.h"
#include "raylign/image/image_view.h"
#include "raylign/tracking/keyframe.h"

namespace raylign {

/// The depth image that a pose is held against, as the sensor gave it.
struct SensedDepth {
  ImageView image;              ///< FLOAT32 m or UINT16 units of 1/scale m
  double scale = 1000.0;        ///< units per m
  double min_depth = 0.0;       ///< m; nearer is no depth
  double max_depth = 1e6;       ///< m; farther is no depth
  double max_difference = 0.1;  ///< of the depth: beyond it, another surface
};

/// Of the points of a keyframe that T_th brings to where `sensed` has depth, the share that lands
/// on it; 1 when there are too few to tell. The intensities may have followed something that moves
/// by itself, or a wrong pose may look alike: depth does not lie with them.
double depth_agreement(const PointList& points,
                       const Matrix4& T_th,
                       const PinholeCamera& camera,
                       const SensedDepth& sensed);

}  // namespace raylign
