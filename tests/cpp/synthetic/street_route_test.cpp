// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/street_route.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raylign {
namespace {

class StreetRouteTest : public testing::TestWithParam<double> {};

INSTANTIATE_TEST_SUITE_P(Lengths,
                         StreetRouteTest,
                         testing::Values(1.0, 120.0, 500.0, 1500.0, 25000.0));

TEST_P(StreetRouteTest, ClosesAfterItsLength) {
  const StreetRoute route(GetParam());
  EXPECT_NEAR(route.length(), std::max(GetParam(), StreetRoute::kMinLength), 1e-6);
  EXPECT_EQ(route.num_segments() % 2, 0);
  const StreetSegment& last = route.segments().back();
  const Vector2 end = last.start + last.length * last.direction;
  EXPECT_NEAR((end - route.segments().front().start).norm(), 0.0, 1e-9);
  EXPECT_NEAR((route.pose(10.0).position - route.pose(10.0 + route.length()).position).norm(), 0.0,
              1e-6);
}

TEST_P(StreetRouteTest, PositionAndHeadingAreContinuous) {
  const StreetRoute route(GetParam());
  constexpr double kStep = 0.05;
  const int count = static_cast<int>(std::min(route.length(), 3000.0) / kStep);
  for (int i = 0; i < count; ++i) {
    const RoutePose a = route.pose(i * kStep);
    const RoutePose b = route.pose((i + 1) * kStep);
    ASSERT_NEAR(a.heading.norm(), 1.0, 1e-12);
    ASSERT_LT((b.position - a.position).norm(), 1.01 * kStep) << i * kStep;
    ASSERT_GT(a.heading.dot(b.heading), std::cos(0.03)) << i * kStep;
  }
}

TEST_P(StreetRouteTest, HousesFitBetweenStreets) {
  const StreetRoute route(GetParam());
  for (int i = 0; i < route.num_segments(); ++i) {
    for (const int side : {-1, 1}) {
      const auto [begin, end] = route.facade_range(i, side);
      EXPECT_GT(end - begin, 5.0) << "segment " << i;
    }
    EXPECT_NEAR(route.segments()[i].direction.dot(route.segments()[route.next(i)].direction), 0.0,
                1e-12);
  }
}

}  // namespace
}  // namespace raylign
