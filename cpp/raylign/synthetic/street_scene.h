// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/synthetic/bal_scene.h"
#include "raylign/synthetic/street_route.h"

namespace raylign {

/// A car drives laps of a closed loop through a city: facades with windows on both sides, trees on
/// the pavements, road markings, towers behind the first row of houses.
class StreetScene : public BalScene {
 public:
  explicit StreetScene(const SyntheticBalOptions& options);

  bool sample(int camera, RandomStream& random, ScenePoint& point) const override;
  bool line_of_sight(int camera, const ScenePoint& point) const override;

  const StreetRoute& route() const { return route_; }

 private:
  struct Ray;
  struct Hit;

  void add_stop(const SyntheticBalOptions& options, int stop, int first_camera);
  bool sample_tree(int camera, RandomStream& random, ScenePoint& point) const;
  bool sample_ground(const Vector3& hit, RandomStream& random, ScenePoint& point) const;
  bool sample_facade(const Hit& hit, RandomStream& random, ScenePoint& point) const;
  bool sample_tower(const Ray& ray, RandomStream& random, ScenePoint& point) const;
  Hit cast(const Ray& ray) const;
  Vector3 to_world(int segment, double along, double across, double height) const;
  double roof_height(int segment, int side, double along) const;

  SyntheticBalOptions options_;
  StreetRoute route_;
  std::vector<std::int32_t> segment_of_camera_;
};

}  // namespace raylign
