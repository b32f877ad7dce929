// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/matches.h"

#include <gtest/gtest.h>

#include "photometric/small_room.h"

namespace raylign::photometric {
namespace {

using test::SmallRoom;
using test::SmallSetting;

std::vector<ImageMatch> matches_between(const SmallSetting& s,
                                        const PhotometricState& before,
                                        const PhotometricState& after) {
  return compare_matches(s.setting, find_views(s.setting, before, 0),
                         find_views(s.setting, after, 0),
                         std::vector<bool>(s.setting.num_points(), true));
}

PhotometricState turned(const SmallRoom& room,
                        const PhotometricState& state,
                        int image,
                        double degrees) {
  PhotometricProblem problem = room.truth();
  Vector6 xi = Vector6::Zero();
  xi[4] = degrees * M_PI / 180.0;
  SmallRoom::set_pose(problem, image, se3_exp(xi) * problem.pose(image));
  PhotometricState other = state;
  other.poses[image] = start_state(problem).poses[image];
  return other;
}

TEST(MatchesTest, AtTheTruthEveryImageIsRight) {
  const SmallRoom room;
  const SmallSetting s(room.truth());
  const auto matches = matches_between(s, turned(room, s.state, 2, 5.0), s.state);
  for (const ImageMatch& match : matches) {
    EXPECT_TRUE(match.is_right()) << match.text();
    EXPECT_GT(match.num_shown, 0.95 * match.num_confirmed);
  }
  EXPECT_LT(matches[2].num_before, 0.3 * matches[2].num_after);
}

TEST(MatchesTest, AnImageThatHasBeenLostIsTheOnlyWrongOne) {
  const SmallRoom room;
  const SmallSetting s(room.truth());
  const auto matches =
      matches_between(s, turned(room, s.state, 2, 5.0), turned(room, s.state, 2, -5.0));
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].is_right(), i != 2) << i << " " << matches[i].text();
  }
}

TEST(MatchesTest, PointsGoneAstrayDoNotMakeImagesWrong) {
  const SmallRoom room;
  const SmallSetting s(room.truth());
  PhotometricState after = s.state;
  for (Eigen::Index p = 0; p < after.points.rows(); ++p) {  // two of three at half their depth
    if (p % 3 == 0) continue;
    const int host = s.setting.hosts.image[p];
    const Vector3 q = 0.5 * after.in_camera(host, after.points.row(p));
    after.points.row(p) = (after.poses[host].q.conjugate() * (q - after.poses[host].t)).transpose();
  }
  for (const ImageMatch& match : matches_between(s, turned(room, s.state, 2, 5.0), after)) {
    EXPECT_LT(2 * match.num_after, match.num_edges);
    EXPECT_TRUE(match.is_right()) << match.text();
  }
}

// What calibration says in numbers.
TEST(MatchesTest, LimitsOfARightImage) {
  ImageMatch match;
  EXPECT_TRUE(match.is_right());  // no edge, nothing to say
  match.num_edges = match.num_tellable = 100;
  match.num_confirmed = 38;
  match.num_after = match.num_shown = 21;
  EXPECT_TRUE(match.is_right());
  match.num_shown = 20;
  EXPECT_FALSE(match.is_right());
  match.num_confirmed = 14;  // too few to mean anything
  EXPECT_FALSE(match.is_right());
  match.num_before = 40;
  match.num_kept = 34;
  EXPECT_TRUE(match.is_right());
  match.num_kept = 33;
  EXPECT_FALSE(match.is_right());
  match.num_after = 50;
  EXPECT_TRUE(match.is_right());
}

}  // namespace
}  // namespace raylign::photometric
