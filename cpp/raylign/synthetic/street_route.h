// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "raylign/base/eigen.h"

namespace raylign {

/// A straight street between two crossings of the loop.
struct StreetSegment {
  Vector2 start;
  Vector2 direction;       ///< unit
  Vector2 left;            ///< unit, direction turned by +90°
  double length = 0.0;     ///< m
  double arc_begin = 0.0;  ///< arc length of the loop at start, m
  int turn_at_end = 0;     ///< +1 left, −1 right
};

/// Where the car is: position and heading in the ground plane.
struct RoutePose {
  Vector2 position;
  Vector2 heading;  ///< unit
  int segment = 0;
};

/// A closed loop of right-angled streets: a block for a short one, a comb through a square city for
/// a long one. Never crosses itself; parallel streets stay so far apart that houses fit between.
class StreetRoute {
 public:
  static constexpr double kHalfWidth = 6.5;    ///< centre line to facade, m
  static constexpr double kMinLength = 120.0;  ///< shortest loop, m

  explicit StreetRoute(double length);

  double length() const { return length_; }
  const std::vector<StreetSegment>& segments() const { return segments_; }
  int next(int segment) const { return segment + 1 == num_segments() ? 0 : segment + 1; }
  int previous(int segment) const { return segment == 0 ? num_segments() - 1 : segment - 1; }
  int num_segments() const { return static_cast<int>(segments_.size()); }

  /// Pose at an arc length (taken modulo the loop); corners are rounded.
  RoutePose pose(double arc) const;

  /// Facade line of one side (+1 left, −1 right): [begin, end] along the segment, crossings mitred.
  std::pair<double, double> facade_range(int segment, int side) const;

 private:
  double length_;
  std::vector<StreetSegment> segments_;
};

}  // namespace raylign
