// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/rescue.h"

#include <gtest/gtest.h>

#include "photometric/small_room.h"
#include "raylign/photometric/constraints.h"

namespace raylign::photometric {
namespace {

using test::SmallRoom;
using test::SmallRoomOptions;
using test::SmallSetting;

constexpr int kLost = 2;

// Everything at the truth but one camera, which has been turned and moved.
struct LostImage {
  explicit LostImage(const PhotometricOptions& options = {}, bool interrupted = false)
      : s(room.truth(), options),
        base(base_constraints(s.setting, s.state, room.config())),
        interrupt([interrupted] { return interrupted; }),
        progress(s.setting.options, clock, no_callback, interrupt) {
    Vector6 xi;
    xi << 0.03, -0.02, 0.04, 0.03, -0.1, 0.05;
    PhotometricProblem problem = room.truth();
    SmallRoom::set_pose(problem, kLost, se3_exp(xi) * problem.pose(kLost));
    state = s.state;
    state.poses[kLost] = start_state(problem).poses[kLost];
    start = state;
  }

  std::vector<std::int32_t> find() {
    return find_lost_images(s.setting, base, start, is_lost, progress, state);
  }
  double degrees_off() const {
    return state.poses[kLost].q.angularDistance(s.state.poses[kLost].q) * 180.0 / M_PI;
  }

  SmallRoom room;
  SmallSetting s;
  PatchConstraints base;
  PhotometricState start, state;
  std::vector<bool> is_lost = {false, false, true, false, false};
  Stopwatch clock;
  IterationCallback no_callback;
  InterruptCheck interrupt;
  Progress progress;
};

TEST(RescueTest, FindsAnImageByThePointsOfTheOthers) {
  LostImage lost;
  EXPECT_GT(lost.degrees_off(), 5.0);
  EXPECT_EQ(lost.find(), std::vector<std::int32_t>{kLost});
  EXPECT_LT(lost.degrees_off(), 0.05);
  EXPECT_LT((lost.state.poses[kLost].t - lost.s.state.poses[kLost].t).norm(), 0.002);
  for (Eigen::Index p = 0; p < lost.state.points.rows(); ++p) {  // its own points come with it
    if (lost.s.setting.hosts.image[p] != kLost) continue;
    const double before = lost.start.in_camera(kLost, lost.start.points.row(p)).z();
    EXPECT_NEAR(lost.state.in_camera(kLost, lost.state.points.row(p)).z(), before, 1e-9);
  }
}

TEST(RescueTest, APointThatIsHeldStaysWhereItIs) {
  LostImage lost;
  Eigen::Index held = -1;
  for (Eigen::Index p = 0; p < lost.state.points.rows() && held < 0; ++p) {
    if (lost.s.setting.hosts.image[p] == kLost) held = p;
  }
  lost.base.points[held] = true;
  EXPECT_EQ(lost.find().size(), 1u);
  EXPECT_EQ(lost.state.points.row(held), lost.start.points.row(held));
}

TEST(RescueTest, LooksOnlyAtPointsThatTheImageMaySee) {
  LostImage lost;
  Candidates& candidates = lost.s.setting.candidates;
  Candidates others;
  others.starts.push_back(0);
  for (std::int64_t p = 0; p + 1 < static_cast<std::int64_t>(candidates.starts.size()); ++p) {
    for (std::int64_t e = candidates.starts[p]; e < candidates.starts[p + 1]; ++e) {
      if (candidates.image[e] != kLost) others.image.push_back(candidates.image[e]);
    }
    others.starts.push_back(others.size());
  }
  candidates = others;
  EXPECT_TRUE(lost.find().empty());
}

TEST(RescueTest, InverseDepthIsNoOther) {
  PhotometricOptions options;
  options.point_parametrization = PointParametrization::INVERSE_DEPTH;
  LostImage lost(options);
  EXPECT_EQ(lost.find().size(), 1u);
  EXPECT_LT(lost.degrees_off(), 0.05);
}

TEST(RescueTest, DoesNotLookForWhatIsHeldNorWhereMostIsWrong) {
  LostImage held;
  held.base.poses[kLost].translation.fill(true);
  held.base.poses[kLost].rotation = true;
  EXPECT_TRUE(held.find().empty());
  LostImage wrong;
  wrong.is_lost = {true, false, true, true, false};
  EXPECT_TRUE(wrong.find().empty());
  EXPECT_GT(wrong.degrees_off(), 5.0);
}

TEST(RescueTest, AnInterruptEndsTheSearch) {
  LostImage lost({}, true);
  EXPECT_TRUE(lost.find().empty());
  EXPECT_TRUE(lost.progress.is_over());
  EXPECT_EQ(lost.progress.summary().termination, Termination::USER_STOPPED);
}

TEST(RescueTest, AdjustRecoversAStartThatOneImageIsLostIn) {
  const SmallRoom room;
  PhotometricProblem start = room.start(0.3, 0.005, 0.01);
  SmallRoom::set_pose(start, kLost, LostImage().state.poses[kLost].matrix());
  PhotometricOptions options;
  options.covariance = CovarianceScope::NONE;
  const PhotometricResult found = adjust(start, room.config(), options);
  EXPECT_TRUE(found.accepted) << found.reason;
  EXPECT_LT(room.centre_error(found.T_cw), 0.002);
  options.num_levels = 2;  // fixed: one attempt
  EXPECT_FALSE(adjust(start, room.config(), options).accepted);
}

}  // namespace
}  // namespace raylign::photometric
