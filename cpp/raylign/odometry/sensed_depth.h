// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "raylign/base/eigen.h"
#include "raylign/camera/pinhole.h"
#include "raylign/depth/depth_model.h"
#include "raylign/image/image_view.h"
#include "raylign/tracking/keyframe.h"

namespace raylign {

/// The depth image that a pose is held against, as the sensor gave it.
struct SensedDepth {
  ImageView image;              ///< FLOAT32 m or UINT16 units of 1/scale m
  double scale = 1000.0;        ///< units per m
  DepthModel model;             ///< range that is believed, and noise
  double max_difference = 0.1;  ///< of the depth: beyond it, another surface

  /// m, 0 where there is none.
  double at(int u, int v) const {
    constexpr double kSaturated = 65535.0;  // what 7-Scenes writes for "no depth"
    const auto* row = static_cast<const std::byte*>(image.data) + v * image.row_stride;
    double z = 0.0;
    if (image.type == PixelType::FLOAT32) {
      z = static_cast<double>(reinterpret_cast<const float*>(row)[u]);
    } else {
      const double raw = reinterpret_cast<const std::uint16_t*>(row)[u];
      z = raw == kSaturated ? 0.0 : raw / scale;
    }
    return z >= model.min_depth && z <= model.max_depth ? z : 0.0;  // NaN: 0
  }
};

/// Calls visit(X, u, v, z) for the points of a keyframe that T_th brings to where the image has
/// depth: the point in the camera, the pixel, and the depth z in m that is seen there. `stride`:
/// every how many points of a tile.
template <typename Visit>
void visit_landings(const PointList& points,
                    const Matrix4& T_th,
                    const PinholeCamera& camera,
                    const SensedDepth& sensed,
                    int stride,
                    const Visit& visit) {
  const tracking::PointArrays arrays = points.arrays();
  for (const PointList::Tile& tile : points.tiles()) {
    for (std::int64_t i = tile.begin; i < tile.begin + tile.count; i += stride) {
      const Vector3 ray(static_cast<double>(arrays.ray_x[i]), static_cast<double>(arrays.ray_y[i]),
                        1.0);
      const auto D = static_cast<double>(arrays.D[i]);
      const Vector3 X = T_th.topLeftCorner<3, 3>() * (ray / D) + T_th.topRightCorner<3, 1>();
      if (!(X.z() > 0.0)) continue;
      const double u = std::round(camera.fx() * X.x() / X.z() + camera.cx());
      const double v = std::round(camera.fy() * X.y() / X.z() + camera.cy());
      if (!(u >= 0.0 && u < sensed.image.width && v >= 0.0 && v < sensed.image.height)) continue;
      const double z = sensed.at(static_cast<int>(u), static_cast<int>(v));
      if (z > 0.0) visit(X, static_cast<int>(u), static_cast<int>(v), z);
    }
  }
}

}  // namespace raylign
