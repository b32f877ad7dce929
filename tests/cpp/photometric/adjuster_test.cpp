// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/adjuster.h"

#include <gtest/gtest.h>

#include <limits>

#include "photometric/small_room.h"
#include "raylign/base/error.h"
#include "raylign/photometric/frozen.h"
#include "raylign/scene/problem_checks.h"

namespace raylign {
namespace {

using test::SmallRoom;
using test::SmallRoomOptions;

PhotometricOptions quick() {
  PhotometricOptions options;
  options.num_levels = 2;
  options.covariance = CovarianceScope::NONE;
  return options;
}

TEST(AdjustTest, FindsTheTruth) {
  const SmallRoom room;
  const PhotometricProblem start = room.start(0.5, 0.01, 0.02);
  const PhotometricResult result = adjust(start, room.config(), quick());
  EXPECT_TRUE(result.accepted) << result.reason;
  EXPECT_LT(room.centre_error(result.T_cw), 0.1 * room.centre_error(start.T_cw));
  EXPECT_NEAR(result.sigma, std::sqrt(2.0), 0.35);  // image and patch
  EXPECT_GT(std::count(result.point_status.begin(), result.point_status.end(), PointStatus::OK),
            0.8 * double(start.num_points()));
  EXPECT_GT(result.shift_px.maxCoeff(), 0.3);
  EXPECT_LT(result.image_rms_after.maxCoeff(), result.image_rms_before.maxCoeff());
}

TEST(AdjustTest, InverseDepthFindsTheTruth) {
  const SmallRoom room;
  PhotometricOptions options = quick();
  options.point_parametrization = PointParametrization::INVERSE_DEPTH;
  const PhotometricProblem start = room.start(0.5, 0.01, 0.02);
  const PhotometricResult result = adjust(start, room.config(), options);
  EXPECT_TRUE(result.accepted) << result.reason;
  EXPECT_LT(room.centre_error(result.T_cw), 0.15 * room.centre_error(start.T_cw));
}

TEST(AdjustTest, EnginesAgree) {
  SmallRoomOptions small;
  small.num_images = 3;
  small.spacing = 20;
  const SmallRoom room(small);
  const PhotometricProblem start = room.start(0.2, 0.004, 0.01);
  PhotometricOptions options = quick();
  options.num_levels = 1;
  options.max_num_rounds = 1;
  options.lm.function_tolerance = 1e-9;
  const PhotometricResult native = adjust(start, room.config(), options);
  options.backend = Backend::CERES;
  const PhotometricResult ceres = adjust(start, room.config(), options);
  EXPECT_LT((native.T_cw - ceres.T_cw).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(AdjustTest, RecoversBrightness) {
  SmallRoomOptions options;
  options.gain = 0.25;
  options.bias = 10.0;
  const SmallRoom room(options);
  const PhotometricResult result = adjust(room.start(0.3, 0.005, 0.01), room.config(), quick());
  EXPECT_TRUE(result.accepted);
  for (int i = 1; i < 5; ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    EXPECT_NEAR(result.brightness(i, 0), -sign * 0.25, 0.01) << i;
    EXPECT_NEAR(result.brightness(i, 1), sign * 10.0 * std::exp(-sign * 0.25), 1.5) << i;
  }
}

TEST(AdjustTest, StoredPatchesWork) {
  SmallRoomOptions options;
  options.stored = true;
  const SmallRoom room(options);
  const PhotometricProblem start = room.start(0.1, 0.003, 0.005);
  const PhotometricResult result = adjust(start, room.config(), quick());
  EXPECT_TRUE(result.accepted) << result.reason;
  EXPECT_LT(room.centre_error(result.T_cw), room.centre_error(start.T_cw));
  ASSERT_EQ(result.messages.size(), 1u);  // level 0 only
}

TEST(AdjustTest, AHopelessStartComesBackBitByBit) {
  const SmallRoom room;
  const PhotometricProblem start = room.start(25.0, 0.5, 0.3);
  PhotometricOptions options = quick();
  options.max_num_rounds = 2;
  const PhotometricResult result = adjust(start, room.config(), options);
  if (result.accepted) {
    EXPECT_LT(room.centre_error(result.T_cw), room.centre_error(start.T_cw));
  } else {
    EXPECT_TRUE(same_bits(result.T_cw, start.T_cw));
    EXPECT_TRUE(same_bits(result.points, start.points));
    EXPECT_FALSE(result.reason.empty());
    EXPECT_EQ(result.shift_px.maxCoeff(), 0.0);
  }
}

TEST(AdjustTest, WhatIsHeldKeepsItsBits) {
  const SmallRoom room;
  const PhotometricProblem start = room.start(0.3, 0.005, 0.01);
  BundleConfig config = room.config();
  config.constant_points = {3, 17};
  const PhotometricResult result = adjust(start, config, quick());
  ASSERT_TRUE(result.accepted);
  EXPECT_TRUE(same_bits(Rows<double, 16>(result.T_cw.row(0)), Rows<double, 16>(start.T_cw.row(0))));
  EXPECT_TRUE(same_bits(Rows<double, 16>(result.T_cw.row(4)), Rows<double, 16>(start.T_cw.row(4))));
  EXPECT_TRUE(
      same_bits(Rows<double, 3>(result.points.row(17)), Rows<double, 3>(start.points.row(17))));
  EXPECT_EQ(result.point_status[17], PointStatus::FIXED);
}

TEST(AdjustTest, SameBitsOnAnyNumberOfThreads) {
  const SmallRoom room;
  const PhotometricProblem start = room.start(0.3, 0.005, 0.01);
  PhotometricOptions options = quick();
  const PhotometricResult one = adjust(start, room.config(), options);
  options.lm.num_threads = 3;
  const PhotometricResult three = adjust(start, room.config(), options);
  EXPECT_TRUE(same_bits(one.T_cw, three.T_cw));
  EXPECT_TRUE(same_bits(one.points, three.points));
}

TEST(AdjustTest, AStopKeepsWhatWasDone) {
  const SmallRoom room;
  const PhotometricProblem start = room.start(0.5, 0.01, 0.02);
  int last = -1;
  const auto callback = [&](const IterationSummary& row) {
    EXPECT_EQ(row.iteration, last + 1);
    last = row.iteration;
    return row.iteration == 6 ? CallbackAction::STOP : CallbackAction::CONTINUE;
  };
  const PhotometricResult result = adjust(start, room.config(), quick(), callback);
  EXPECT_EQ(last, 6);
  EXPECT_EQ(result.summary.termination, Termination::USER_STOPPED);
  EXPECT_EQ(result.summary.iterations.back().iteration, 6);
  if (result.accepted) {
    EXPECT_LT(room.centre_error(result.T_cw), room.centre_error(start.T_cw));
  }
}

TEST(AdjustTest, CovariancesComeWithTheResult) {
  const SmallRoom room;
  PhotometricOptions options = quick();
  options.covariance = CovarianceScope::ALL;
  const PhotometricResult result = adjust(room.start(0.3, 0.005, 0.01), room.config(), options);
  ASSERT_TRUE(result.accepted);
  ASSERT_EQ(result.pose_covariance.rows(), 30);
  EXPECT_EQ(result.pose_covariance.topLeftCorner(6, 6).norm(), 0.0);  // held
  EXPECT_GT(result.pose_covariance(6, 6), 0.0);
  EXPECT_EQ(result.point_covariances.rows(), room.truth().num_points());
  EXPECT_EQ(result.free_directions, 0);
}

TEST(FreezeTest, IsWhatASolveStartsFrom) {
  const SmallRoom room;
  const FrozenProblem frozen = freeze(room.truth(), room.config(), quick());
  frozen.scene.validate();
  EXPECT_TRUE(frozen.constraints.poses[0].all());
  EXPECT_FALSE(frozen.constraints.poses[1].any());
  EXPECT_EQ(frozen.options.loss.type, LossType::STUDENT_T);
  EXPECT_GT(frozen.scene.num_edges(), 2 * room.truth().num_points());
}

// What a user may hand over by mistake.
class HostileTest : public testing::Test {
 protected:
  void expect_shape_error(const PhotometricProblem& problem, const std::string& part) const {
    try {
      adjust(problem, room_.config(), quick());
      FAIL() << "no error: " << part;
    } catch (const ShapeError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
  SmallRoom room_;
  PhotometricProblem problem_ = room_.truth();
};

TEST_F(HostileTest, NanPose) {
  problem_.T_cw(2, 3) = std::numeric_limits<double>::quiet_NaN();
  expect_shape_error(problem_, "T_cw[2]");
}

TEST_F(HostileTest, LeftHandedRotation) {
  Matrix4 T = problem_.pose(1);
  T.row(0) *= -1.0;
  SmallRoom::set_pose(problem_, 1, T);
  expect_shape_error(problem_, "T_cw[1]");
}

TEST_F(HostileTest, NoPointInView) {
  problem_.points.col(2).array() -= 100.0;
  expect_shape_error(problem_, "no point is in view");
}

TEST_F(HostileTest, CameraToWorldPoses) {
  for (int i = 0; i < 5; ++i) {
    Matrix4 T = problem_.pose(i);
    T(2, 3) = -50.0;
    SmallRoom::set_pose(problem_, i, T);
  }
  expect_shape_error(problem_, "camera to world");
}

TEST_F(HostileTest, IntrinsicsOfAnotherResolution) {
  problem_.intrinsics *= 4.0;
  problem_.host_uv.resize(0, 2);
  try {
    const PhotometricResult result = adjust(problem_, room_.config(), quick());
    ASSERT_FALSE(result.messages.empty());
    EXPECT_NE(result.messages[0].find("another resolution"), std::string::npos);
  } catch (const ShapeError& error) {
    EXPECT_NE(std::string(error.what()).find("another resolution"), std::string::npos);
  }
}

TEST_F(HostileTest, NothingAtAll) {
  PhotometricProblem empty;
  empty.intrinsics = problem_.intrinsics;
  BundleConfig config;
  EXPECT_THROW(adjust(empty, config, quick()), ShapeError);
}

TEST_F(HostileTest, ArraysThatDoNotFit) {
  PhotometricProblem short_hosts = problem_;
  short_hosts.hosts.conservativeResize(5);
  expect_shape_error(short_hosts, "PhotometricProblem.hosts");
  PhotometricProblem bad_host = problem_;
  bad_host.hosts[7] = 5;
  expect_shape_error(bad_host, "hosts[7]");
  PhotometricProblem bad_prior = problem_;
  bad_prior.pose_covariances.setZero(5, 36);
  expect_shape_error(bad_prior, "pose_covariances[0]");
}

TEST_F(HostileTest, FlatImages) {
  for (auto& image : problem_.images) {
    const std::vector<float> grey(SmallRoom::kWidth * SmallRoom::kHeight, 100.0f);
    image = std::make_shared<ImagePyramid>(ImageView{grey.data(), PixelType::FLOAT32,
                                                     SmallRoom::kWidth, SmallRoom::kHeight, 1,
                                                     sizeof(float) * SmallRoom::kWidth});
  }
  const PhotometricResult result = adjust(problem_, room_.config(), quick());
  EXPECT_FALSE(result.accepted);
  EXPECT_EQ(result.point_status[0], PointStatus::LOW_TEXTURE);
  EXPECT_TRUE(same_bits(result.T_cw, problem_.T_cw));
}

}  // namespace
}  // namespace raylign
