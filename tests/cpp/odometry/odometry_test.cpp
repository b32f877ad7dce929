// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/rgbd_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "raylign/base/error.h"
#include "tracking/plane_scene.h"

namespace raylign {
namespace {

using test::PlaneScene;
using test::pose_error;

constexpr double kFrameTime = 1.0 / 30.0;

/// A camera that moves through the corner of planes, as a depth camera sees it.
class Ride {
 public:
  Matrix4 T_cw(int frame) const {
    Vector6 xi;
    xi << 0.012, -0.009, 0.006, 0.005, 0.008, -0.003;
    return se3_exp(Vector6(frame * xi));
  }
  OdometryResult step(RgbdOdometry& odometry, int frame) {
    shoot(T_cw(frame));
    return odometry.track(image(), depth(), frame * kFrameTime);
  }
  void shoot(const Matrix4& T_cw) {
    scene_.render(T_cw, image_, depth_);
    for (std::size_t i = 0; i < depth_.size(); ++i) depth_.data()[i] = 1.0F / depth_.data()[i];
  }
  ImageView image() const { return PlaneScene::view_of(image_); }
  ImageView depth() const { return PlaneScene::view_of(depth_); }
  PinholeCamera camera() const { return scene_.camera(); }
  Plane<float>& depth_plane() { return depth_; }
  /// Replaces this share of the image by noise, uniform in [0, 256).
  void add_noise(float share) {
    unsigned state = 1;
    for (std::size_t i = 0; i < image_.size(); ++i) {
      state = state * 1664525U + 1013904223U;
      float& pixel = image_.data()[i];
      pixel += share * (static_cast<float>(state >> 24U) - pixel);
    }
  }

 private:
  PlaneScene scene_;
  Plane<float> image_, depth_;
};

OdometryOptions options_with(bool depth_term) {
  OdometryOptions options;
  options.tracking.depth.enabled = depth_term;
  return options;
}

class OdometryTest : public testing::TestWithParam<bool> {};

TEST_P(OdometryTest, FollowsTheCamera) {
  Ride ride;
  RgbdOdometry odometry(ride.camera(), options_with(GetParam()));
  for (int i = 0; i < 12; ++i) {
    const OdometryResult result = ride.step(odometry, i);
    ASSERT_EQ(result.status, OdometryStatus::OK) << i << ": " << result.reason;
    EXPECT_EQ(result.frame, i);
    EXPECT_LT(pose_error(se3_inverse(result.T_wc), ride.T_cw(i)).norm(), 5e-3) << i;
  }
}

// Frames are kept and filled again, and without the depth term their depth is only looked at when
// one becomes a keyframe: neither may show.
TEST_P(OdometryTest, EveryFrameAsAKeyframeFollowsToo) {
  Ride ride;
  OdometryOptions options = options_with(GetParam());
  options.keyframe_rule.distance_weight = 1e6;
  options.num_recovery_keyframes = 2;
  RgbdOdometry odometry(ride.camera(), options);
  for (int i = 0; i < 12; ++i) {
    const OdometryResult result = ride.step(odometry, i);
    ASSERT_EQ(result.status, OdometryStatus::OK) << i << ": " << result.reason;
    EXPECT_TRUE(result.is_keyframe);
    EXPECT_EQ(result.keyframe, std::max(0, i - 1));
    EXPECT_LT(pose_error(se3_inverse(result.T_wc), ride.T_cw(i)).norm(), 1e-2) << i;
  }
}

TEST_P(OdometryTest, IsLostOnNoiseAndRecovers) {
  Ride ride;
  RgbdOdometry odometry(ride.camera(), options_with(GetParam()));
  for (int i = 0; i < 3; ++i) ride.step(odometry, i);
  ride.shoot(ride.T_cw(3));
  ride.add_noise(1.0F);
  const OdometryResult lost = odometry.track(ride.image(), ride.depth(), 3 * kFrameTime);
  EXPECT_EQ(lost.status, OdometryStatus::LOST);
  EXPECT_TRUE(std::isnan(lost.T_wc(0, 0)));
  EXPECT_FALSE(lost.reason.empty());
  const OdometryResult found = ride.step(odometry, 4);
  EXPECT_EQ(found.status, OdometryStatus::RECOVERED) << found.reason;
  EXPECT_LT(pose_error(se3_inverse(found.T_wc), ride.T_cw(4)).norm(), 5e-3);
}

TEST_P(OdometryTest, BeginsWithTheFirstFrameThatHasDepth) {
  Ride ride;
  RgbdOdometry odometry(ride.camera(), options_with(GetParam()));
  ride.shoot(ride.T_cw(0));
  ride.depth_plane().data()[0] = 1.0F;
  std::fill(ride.depth_plane().data() + 1, ride.depth_plane().data() + ride.depth_plane().size(),
            std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(odometry.track(ride.image(), ride.depth(), -1.0).status, OdometryStatus::NO_DEPTH);
  EXPECT_EQ(ride.step(odometry, 0).status, OdometryStatus::OK);
  EXPECT_EQ(ride.step(odometry, 1).keyframe, 1);  // counted from the first, which had no depth
}

INSTANTIATE_TEST_SUITE_P(Terms, OdometryTest, testing::Bool(), [](const auto& test) {
  return std::string(test.param ? "with_depth" : "photometric");
});

TEST(Odometry, ANewKeyframeComesBeforeTheImagesDisagree) {
  Ride ride;
  OdometryOptions options;
  options.keyframe_rule = {0.0, 0.0, 0.0, 0.9};
  RgbdOdometry odometry(ride.camera(), options);
  ride.step(odometry, 0);
  ride.shoot(ride.T_cw(1));
  EXPECT_FALSE(odometry.track(ride.image(), ride.depth(), kFrameTime).is_keyframe);
  ride.shoot(ride.T_cw(2));
  ride.add_noise(0.3F);
  const OdometryResult noisy = odometry.track(ride.image(), ride.depth(), 2 * kFrameTime);
  EXPECT_EQ(noisy.status, OdometryStatus::OK);
  EXPECT_LT(noisy.alignment.agreement, 0.9);
  EXPECT_TRUE(noisy.is_keyframe);
}

TEST(Odometry, RefusesWhatDoesNotFit) {
  Ride ride;
  RgbdOdometry odometry(ride.camera(), options_with(false));
  ride.step(odometry, 1);
  EXPECT_THROW(odometry.track(ride.image(), ride.depth(), kFrameTime), OptionsError);
  ImageView bytes = ride.depth();
  bytes.type = PixelType::UINT8;
  EXPECT_THROW(odometry.track(ride.image(), bytes, 1.0), ShapeError);
  for (const auto& spoil : std::vector<std::function<void(OdometryOptions&)>>{
           [](OdometryOptions& o) { o.min_depth_agreement = 1.5; },
           [](OdometryOptions& o) { o.max_depth_step = 0.0; },
           [](OdometryOptions& o) { o.shutter.readout_s = std::nan(""); },
           [](OdometryOptions& o) { o.keyframe_rule.min_agreement = -0.1; },
           [](OdometryOptions& o) { o.tracking.motion = MotionGroup::SIM3; }}) {
    OdometryOptions options;
    spoil(options);
    EXPECT_THROW(RgbdOdometry(ride.camera(), options), OptionsError);
  }
}

TEST(DepthAgreement, IsTheShareOfPointsOnTheirDepth) {
  Ride ride;
  ride.shoot(Matrix4::Identity());
  const PlaneScene scene;
  const Keyframe keyframe(scene.frame(Matrix4::Identity(), 1e-6));
  SensedDepth sensed;
  sensed.image = ride.depth();
  const auto share = [&](const Matrix4& T_th) {
    return depth_agreement(keyframe.points(1), T_th, ride.camera(), sensed);
  };
  EXPECT_GT(share(Matrix4::Identity()), 0.99);
  Matrix4 nearer = Matrix4::Identity();
  nearer(2, 3) = -0.5;
  EXPECT_LT(share(nearer), 0.05);
  // the left half shows something else, then nothing
  for (int v = 0; v < scene.height; ++v) {
    std::fill_n(ride.depth_plane().row(v), scene.width / 2, 0.7F);
  }
  const double half = share(Matrix4::Identity());
  EXPECT_GT(half, 0.3);
  EXPECT_LT(half, 0.7);
  for (int v = 0; v < scene.height; ++v) {
    std::fill_n(ride.depth_plane().row(v), scene.width / 2, 0.0F);
  }
  EXPECT_GT(share(Matrix4::Identity()), 0.99);
}

TEST(DepthAgreement, ReadsIntegersAsTheirScaleSays) {
  Ride ride;
  ride.shoot(Matrix4::Identity());
  std::vector<std::uint16_t> units(ride.depth_plane().size());
  for (std::size_t i = 0; i < units.size(); ++i) {
    units[i] = static_cast<std::uint16_t>(std::lround(5000.0F * ride.depth_plane().data()[i]));
  }
  const PlaneScene scene;
  const Keyframe keyframe(scene.frame(Matrix4::Identity(), 1e-6));
  SensedDepth sensed;
  sensed.image = {units.data(),
                  PixelType::UINT16,
                  scene.width,
                  scene.height,
                  1,
                  2 * static_cast<std::size_t>(scene.width)};
  sensed.scale = 5000.0;
  const auto share = [&] {
    return depth_agreement(keyframe.points(1), Matrix4::Identity(), ride.camera(), sensed);
  };
  EXPECT_GT(share(), 0.99);
  std::fill(units.begin(), units.end(), std::uint16_t{65535});  // no depth anywhere
  sensed.model.max_depth = 1e3;
  EXPECT_EQ(share(), 1.0);
}

TEST(DepthStep, LeadsBackToThePose) {
  Ride ride;
  ride.shoot(Matrix4::Identity());
  const PlaneScene scene;
  const Keyframe keyframe(scene.frame(Matrix4::Identity(), 1e-6));
  SensedDepth sensed;
  sensed.image = ride.depth();
  Vector6 xi;
  xi << 0.03, -0.02, 0.02, 0.01, -0.015, 0.01;
  const auto step = [&](const Matrix4& T_th) {
    return depth_step(keyframe.points(0), T_th, ride.camera(), sensed);
  };
  EXPECT_LT(step(Matrix4::Identity()).norm(), 2e-3);
  const Matrix4 wrong = se3_exp(xi);
  EXPECT_LT(se3_log(se3_exp(step(wrong)) * wrong).norm(), 0.25 * xi.norm());
  // another surface, everywhere
  std::fill_n(ride.depth_plane().data(), ride.depth_plane().size(), 0.5F);
  EXPECT_EQ(step(wrong).norm(), 0.0);
}

}  // namespace
}  // namespace raylign
