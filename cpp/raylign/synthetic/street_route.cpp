// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/street_route.h"

#include <algorithm>
#include <cmath>

namespace raylign {
namespace {

constexpr double kBlock = 90.0;        // distance of parallel streets of a large city, m
constexpr double kCornerRadius = 5.5;  // where the rounding of a corner begins, m

// Corners of a comb with n columns (even): up, over, down to the second row, over, up …, home along
// row 0. Its length is n · height + n · pitch; n = 2 is a rectangle.
std::vector<Vector2> comb(double length) {
  int n = 2 * static_cast<int>(std::floor(0.5 * std::sqrt(length / kBlock) + 0.5));
  if (n < 4) n = 2;
  const double pitch = n == 2 ? std::min(0.21 * length, 2.0 * kBlock) : kBlock;
  const double height = length / n - pitch;
  std::vector<Vector2> corners;
  for (int column = 0; column < n; ++column) {
    const double x = column * pitch;
    const double low = column == 0 || column == n - 1 ? 0.0 : pitch;
    const bool up = column % 2 == 0;
    corners.emplace_back(x, up ? low : height);
    corners.emplace_back(x, up ? height : low);
  }
  const Vector2 center(0.5 * (n - 1) * pitch, 0.5 * height);
  for (Vector2& corner : corners) corner -= center;
  return corners;
}

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

StreetRoute::StreetRoute(double length) : length_(std::max(length, kMinLength)) {
  const std::vector<Vector2> corners = comb(length_);
  double arc = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    StreetSegment segment;
    const Vector2 along = corners[(i + 1) % corners.size()] - corners[i];
    segment.start = corners[i];
    segment.length = along.norm();
    segment.direction = along / segment.length;
    segment.left = Vector2(-segment.direction.y(), segment.direction.x());
    segment.arc_begin = arc;
    arc += segment.length;
    segments_.push_back(segment);
  }
  length_ = arc;
  for (int i = 0; i < num_segments(); ++i) {
    segments_[i].turn_at_end =
        cross(segments_[i].direction, segments_[next(i)].direction) > 0 ? 1 : -1;
  }
}

RoutePose StreetRoute::pose(double arc) const {
  arc -= length_ * std::floor(arc / length_);
  const auto after =
      std::upper_bound(segments_.begin(), segments_.end(), arc,
                       [](double a, const StreetSegment& s) { return a < s.arc_begin; });
  const int i = static_cast<int>(after - segments_.begin()) - 1;
  const StreetSegment& here = segments_[i];
  const double along = arc - here.arc_begin;
  const double rest = here.length - along;
  if (along >= kCornerRadius && rest >= kCornerRadius) {
    return {here.start + along * here.direction, here.direction, i};
  }
  // A quadratic Bézier curve with the corner as its middle control point.
  const bool at_end = rest < kCornerRadius;
  const StreetSegment& in = at_end ? here : segments_[previous(i)];
  const StreetSegment& out = at_end ? segments_[next(i)] : here;
  const double tau = 0.5 + 0.5 * (at_end ? -rest : along) / kCornerRadius;
  const Vector2 heading = (1.0 - tau) * in.direction + tau * out.direction;
  const Vector2 position = out.start + kCornerRadius * (tau * tau * out.direction -
                                                        (1.0 - tau) * (1.0 - tau) * in.direction);
  return {position, heading / heading.norm(), i};
}

std::pair<double, double> StreetRoute::facade_range(int segment, int side) const {
  const StreetSegment& here = segments_[segment];
  const bool inner_begin = segments_[previous(segment)].turn_at_end == side;
  const bool inner_end = here.turn_at_end == side;
  return {inner_begin ? kHalfWidth : -kHalfWidth,
          here.length + (inner_end ? -kHalfWidth : kHalfWidth)};
}

}  // namespace raylign
