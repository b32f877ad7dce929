// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/occlusion.h"

#include <cmath>
#include <limits>

namespace raylign::photometric {
namespace {

struct Splat {
  double depth = std::numeric_limits<double>::infinity();
  std::int64_t point = -1;
};

// The nearest patch of each cell of one image.
class ZBuffer {
 public:
  ZBuffer(int width, int height, double cell)
      : cell_(cell),
        columns_(static_cast<int>(width / cell) + 1),
        rows_(static_cast<int>(height / cell) + 1),
        splats_(static_cast<std::size_t>(columns_) * rows_) {}

  /// Into the cells that a square of one cell around uv touches.
  void splat(const Vector2& uv, double depth, std::int64_t point) {
    for (const double dv : {-0.5, 0.5}) {
      for (const double du : {-0.5, 0.5}) {
        Splat* at = find(uv.x() + du * cell_, uv.y() + dv * cell_);
        if (at != nullptr && depth < at->depth) *at = {depth, point};
      }
    }
  }

  Splat* find(double u, double v) {
    const double column = std::floor(u / cell_);
    const double row = std::floor(v / cell_);
    if (!(column >= 0.0 && column < columns_ && row >= 0.0 && row < rows_)) return nullptr;
    return &splats_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)];
  }

 private:
  double cell_;
  int columns_, rows_;
  std::vector<Splat> splats_;
};

// Depth of the patch of point `front` on the ray through uv of an image.
double depth_on_ray(const Setting& setting,
                    const PhotometricState& state,
                    const Views& views,
                    std::int32_t image,
                    const Vector2& uv,
                    const Splat& front) {
  const auto normal = views.normals.row(front.point);
  if (!normal.allFinite()) return front.depth;
  const PatchPose& host = state.poses[setting.hosts.image[front.point]];
  const Vector3 n = state.poses[image].q * (host.q.conjugate() * Vector3(normal));
  const Vector3 q = state.in_camera(image, state.points.row(front.point));
  const double depth = n.dot(q) / n.dot(state.ray(image, uv));
  return depth > 0.0 ? depth : front.depth;
}

struct Seen {
  std::int64_t edge;
  std::int64_t point;
  Vector2 uv;
  double depth;
};

}  // namespace

void mark_occluded(const Setting& setting,
                   const PhotometricState& state,
                   double cell,
                   Views& views) {
  std::vector<std::vector<Seen>> by_image(state.poses.size());
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      const std::int32_t image = views.scene.edges[e].image;
      Vector2 uv;
      if (views.edges[e] != EdgeStatus::OK || !state.project(image, state.points.row(p), uv)) {
        continue;
      }
      by_image[image].push_back({e, p, uv, state.in_camera(image, state.points.row(p)).z()});
    }
  }
  setting.pool.run(static_cast<int>(by_image.size()), [&](int image) {
    const PatchImage& pixels = *setting.prepared.images[image];
    ZBuffer buffer(pixels.width(0), pixels.height(0), cell);
    for (const Seen& seen : by_image[image]) buffer.splat(seen.uv, seen.depth, seen.point);
    for (const Seen& seen : by_image[image]) {
      const Splat* front = buffer.find(seen.uv.x(), seen.uv.y());
      if (front == nullptr || front->point < 0 || front->point == seen.point) continue;
      const double nearest = (1.0 - setting.options.visibility.occlusion) * seen.depth;
      if (front->depth < nearest &&
          depth_on_ray(setting, state, views, image, seen.uv, *front) < nearest) {
        views.edges[seen.edge] = EdgeStatus::OCCLUDED;
      }
    }
  });
}

}  // namespace raylign::photometric
