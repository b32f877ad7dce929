// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/depth_agreement.h"

#include <cmath>
#include <cstdint>

namespace raylign {
namespace {

constexpr int kMinPoints = 20;
constexpr double kSaturated = 65535.0;  // what 7-Scenes writes for "no depth"

// m, 0: none.
double depth_at(const SensedDepth& sensed, int u, int v) {
  const ImageView& image = sensed.image;
  const auto* row = static_cast<const std::byte*>(image.data) + v * image.row_stride;
  double z = 0.0;
  if (image.type == PixelType::FLOAT32) {
    z = static_cast<double>(reinterpret_cast<const float*>(row)[u]);
  } else {
    const double raw = reinterpret_cast<const std::uint16_t*>(row)[u];
    z = raw == kSaturated ? 0.0 : raw / sensed.scale;
  }
  return z >= sensed.min_depth && z <= sensed.max_depth ? z : 0.0;  // NaN: 0
}

}  // namespace

double depth_agreement(const PointList& points,
                       const Matrix4& T_th,
                       const PinholeCamera& camera,
                       const SensedDepth& sensed) {
  const tracking::PointArrays arrays = points.arrays();
  int compared = 0;
  int agreeing = 0;
  for (const PointList::Tile& tile : points.tiles()) {
    for (std::int64_t i = tile.begin; i < tile.begin + tile.count; ++i) {
      const Vector3 ray(static_cast<double>(arrays.ray_x[i]), static_cast<double>(arrays.ray_y[i]),
                        1.0);
      const auto D = static_cast<double>(arrays.D[i]);
      const Vector3 X = T_th.topLeftCorner<3, 3>() * (ray / D) + T_th.topRightCorner<3, 1>();
      if (!(X.z() > 0.0)) continue;
      const double u = std::round(camera.fx() * X.x() / X.z() + camera.cx());
      const double v = std::round(camera.fy() * X.y() / X.z() + camera.cy());
      if (!(u >= 0.0 && u < sensed.image.width && v >= 0.0 && v < sensed.image.height)) continue;
      const double z = depth_at(sensed, static_cast<int>(u), static_cast<int>(v));
      if (z == 0.0) continue;
      ++compared;
      if (std::abs(X.z() - z) <= sensed.max_difference * z) ++agreeing;
    }
  }
  return compared < kMinPoints ? 1.0 : static_cast<double>(agreeing) / compared;
}

}  // namespace raylign
