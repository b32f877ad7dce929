// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/shutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raylign/tracking/aligner.h"
#include "tracking/plane_scene.h"

namespace raylign {
namespace {

using test::PlaneScene;
using test::pose_error;

constexpr double kReadout = 0.03;   // s
constexpr double kInterval = 0.04;  // s

Vector6 twist(double a, double b, double c, double d, double e, double f) {
  Vector6 xi;
  xi << a, b, c, d, e, f;
  return xi;
}

// A keyframe, and `kInterval` later a target, both read by rows while the camera moves.
class ShutterTest : public testing::TestWithParam<bool> {
 protected:
  ShutterTest()
      : keyframe_(scene().frame(Matrix4::Identity(), 1e-6, Vector6(kReadout * host_velocity()))) {}

  static PlaneScene scene() {
    PlaneScene scene;
    scene.width = 640;
    scene.height = 480;
    scene.frequency = 2.0;
    return scene;
  }
  static Vector6 host_velocity() { return twist(0.3, 0.1, -0.1, 0.2, 0.4, -0.2); }
  static Vector6 target_velocity() { return twist(-0.2, 0.2, 0.2, -0.4, -0.3, 0.5); }
  static Matrix4 truth() { return se3_exp(Vector6(kInterval * target_velocity())); }
  // The keyframe's own camera was there before.
  static Shutter shutter(double readout_s) {
    Shutter shutter;
    shutter.readout_s = readout_s;
    shutter.has_motion = true;
    shutter.host_velocity = host_velocity();
    shutter.elapsed_s = kInterval;
    return shutter;
  }
  AlignmentResult align(double readout_s, const Matrix4& start, int iterations) const {
    TrackingOptions options;
    options.affine.mode = AffineMode::NONE;
    options.rotation_first = false;
    options.depth.estimate_weight = false;
    options.lm.max_num_iterations = iterations;
    options.lm.function_tolerance = 1e-9;
    AlignmentStart from;
    from.T_th = start;
    from.shutter = shutter(readout_s);
    const double variance = GetParam() ? 1e-6 : 0.0;
    const auto target = scene().frame(truth(), variance, Vector6(kReadout * target_velocity()));
    return Aligner(options).align(keyframe_, *target, from);
  }
  double cost_at(double readout_s, const Matrix4& T_th) const {
    return align(readout_s, T_th, 0).levels.back().summary.initial_cost;
  }

 private:
  Keyframe keyframe_;
};

TEST_P(ShutterTest, FindsThePoseOfTheMiddleRow) {
  const Vector6 error = pose_error(align(kReadout, Matrix4::Identity(), 30).T_th, truth());
  const Vector6 rigid = pose_error(align(0.0, Matrix4::Identity(), 30).T_th, truth());
  EXPECT_LT(error.head<3>().norm(), 4e-3);
  EXPECT_LT(error.tail<3>().norm(), 1.5e-3);
  EXPECT_LT(error.norm(), 0.25 * rigid.norm());
}

// With the pose held, the gradient is that of the cost, up to what a central difference of pixels
// is worth.
TEST_P(ShutterTest, GradientIsThatOfTheCost) {
  const AlignmentResult found = align(0.02, truth(), 30);
  const double step = 5e-4;
  const double numeric =
      (cost_at(0.02 + step, found.T_th) - cost_at(0.02 - step, found.T_th)) / (2.0 * step);
  EXPECT_NEAR(found.readout.gradient, numeric, 0.08 * std::abs(numeric));
}

TEST_P(ShutterTest, StepsFindTheReadoutTime) {
  double readout_s = 0.0;
  for (int i = 0; i < 4; ++i) {
    const AlignmentResult result = align(readout_s, Matrix4::Identity(), 30);
    ASSERT_GT(result.readout.information, 0.0);
    readout_s -= result.readout.gradient / result.readout.information;
  }
  EXPECT_NEAR(readout_s, kReadout, 0.03 * kReadout);
}

INSTANTIATE_TEST_SUITE_P(Terms, ShutterTest, testing::Bool(), [](const auto& test) {
  return std::string(test.param ? "with_depth" : "photometric");
});

TEST(Shutter, NoMotionNoEquation) {
  const PlaneScene scene;
  const Keyframe keyframe(scene.frame(Matrix4::Identity(), 1e-6));
  AlignmentStart start;
  start.shutter.readout_s = kReadout;
  const AlignmentResult result =
      Aligner(TrackingOptions())
          .align(keyframe, *scene.frame(se3_exp(twist(0.02, 0, 0, 0, 0.01, 0))), start);
  EXPECT_EQ(result.readout.information, 0.0);
  EXPECT_EQ(result.status, AlignmentStatus::OK);
}

}  // namespace
}  // namespace raylign
