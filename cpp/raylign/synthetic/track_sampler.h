// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/synthetic/bal_options.h"
#include "raylign/synthetic/bal_scene.h"
#include "raylign/synthetic/camera_neighbors.h"

namespace raylign {

/// Draws point j and the cameras that see it. Everything about point j is a function of (seed, j):
/// points may be drawn in any order and as often as wanted; drawing them in order is fast.
class TrackSampler {
 public:
  static constexpr int kMaxTrackLength = static_cast<int>(NeighborList::kMaxSize) + 1;

  TrackSampler(const SyntheticBalOptions& options, const BalScene& scene);

  /// Camera whose picture point j is drawn from; ascending in j.
  int reference_camera(std::int64_t j) const;

  /// One try at point j. False when it hits no surface or its reference camera does not see it.
  bool sample(std::int64_t j, int attempt, ScenePoint& point) const;

  /// The first `limit` cameras that observe the point, reference camera first; a smaller limit
  /// gives a prefix. Size 1: no other camera does. Not const: caches the neighbours of the
  /// reference camera.
  void walk(std::int64_t j,
            int attempt,
            const ScenePoint& point,
            int limit,
            std::vector<std::int32_t>& track);

  /// x >= 0 with P(x > y) = (1 + y)⁻²: λ x is the tail of track lengths with mean λ.
  double tail_draw(std::int64_t j) const;

  /// Pixel of a world point, exact.
  Vector2 project(int camera, const Vector3& p_w) const;

 private:
  bool sample_far(int camera, RandomStream& random, ScenePoint& point) const;
  bool is_visible(int camera, const ScenePoint& point) const;
  void load_neighbors(int camera);
  std::int32_t find_earlier(int camera, const ScenePoint& point);
  /// The first point of camera i > 0 is seen by a camera before i: the camera graph becomes one
  /// tree.
  bool is_link(std::int64_t j) const;

  const SyntheticBalOptions options_;
  const BalScene& scene_;
  CameraNeighbors neighbors_;
  double max_squared_radius_;
  std::vector<std::int64_t>
      point_begin_;  // points of camera i: [point_begin_[i], point_begin_[i + 1])
  int cached_camera_ = -1;
  NeighborList cached_neighbors_;
};

}  // namespace raylign
