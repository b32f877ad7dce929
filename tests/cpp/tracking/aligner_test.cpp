// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/aligner.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/geometry/sim3.h"
#include "support/named_rng.h"
#include "tracking/plane_scene.h"

namespace raylign {
namespace {

using test::PlaneScene;
using test::pose_error;

Matrix4 some_motion(double size = 1.0) {
  Vector6 xi;
  xi << 0.02, -0.015, 0.02, 0.008, 0.012, -0.01;
  return se3_exp(Vector6(size * xi));
}

TrackingOptions finest() {
  TrackingOptions options;
  options.finest_level = 0;
  return options;
}

AlignmentResult align(const Keyframe& keyframe,
                      const Frame& target,
                      const TrackingOptions& options = finest(),
                      const AlignmentStart& start = {},
                      bool with_maps = false) {
  return Aligner(options).align(keyframe, target, start, with_maps);
}

Keyframe keyframe_of(const PlaneScene& scene, const KeyframeOptions& options = {}) {
  return Keyframe(scene.frame(Matrix4::Identity(), 1e-6), options);
}

struct Kind {
  const char* name;
  AffineMode affine;
  GradientMode gradient;
  bool with_depth;
};

class RecoveryTest : public testing::TestWithParam<Kind> {};

TEST_P(RecoveryTest, FindsTheExactPose) {
  PlaneScene scene;
  scene.width = 640;
  scene.height = 480;
  scene.frequency = 2.0;
  TrackingOptions options = finest();
  options.affine.mode = GetParam().affine;
  options.gradient = GetParam().gradient;
  const auto target = scene.frame(some_motion(2.0), GetParam().with_depth ? 1e-6 : 0.0);
  const AlignmentResult result = align(keyframe_of(scene), *target, options);
  ASSERT_EQ(result.status, AlignmentStatus::OK) << result.reason;
  const Vector6 error = pose_error(result.T_th, some_motion(2.0));
  EXPECT_LT(error.head<3>().norm(), 1e-4);
  EXPECT_LT(error.tail<3>().norm(), 5e-5);  // 0.003°
}

INSTANTIATE_TEST_SUITE_P(
    Kinds,
    RecoveryTest,
    testing::Values(Kind{"none", AffineMode::NONE, GradientMode::FORWARD, false},
                    Kind{"joint", AffineMode::JOINT, GradientMode::FORWARD, false},
                    Kind{"closed_form", AffineMode::CLOSED_FORM, GradientMode::FORWARD, false},
                    Kind{"esm", AffineMode::NONE, GradientMode::ESM, false},
                    Kind{"depth", AffineMode::JOINT, GradientMode::FORWARD, true}),
    [](const auto& test) { return std::string(test.param.name); });

// A shift of half a pixel in the pyramid's cameras would show on every coarse level.
TEST(Aligner, EveryLevelIsUnbiased) {
  PlaneScene scene;
  scene.width = 640;
  scene.height = 480;
  scene.frequency = 3.0;
  const Keyframe keyframe = keyframe_of(scene);
  const auto target = scene.frame(some_motion());
  for (int level = 1; level <= 3; ++level) {
    TrackingOptions options;
    options.finest_level = level;
    const AlignmentResult result = align(keyframe, *target, options);
    ASSERT_EQ(result.status, AlignmentStatus::OK) << result.reason;
    // half a pixel of the level would be 1e-3 · 2^level
    const Vector6 error = pose_error(result.T_th, some_motion());
    EXPECT_LT(error.norm(), 4e-4 * (1 << level)) << level;
  }
}

// Some points see another surface. Told sigma is wide, they count as noise; the residuals of the
// rest tell what it is.
TEST(Aligner, SigmaAdaptsToImagesWithLittleNoise) {
  PlaneScene scene;
  scene.width = 320;
  scene.height = 240;
  Plane<float> image;
  Plane<float> D;
  scene.render(some_motion(), image, D);
  for (int v = 90; v < 125; ++v) {
    for (int u = 60; u < 100; ++u) image.at(u, v) += 12.0F;
  }
  const auto target = scene.frame_of(image, D, 0.0);
  TrackingOptions options = finest();
  const AlignmentResult adapted = align(keyframe_of(scene), *target, options);
  options.adapt_sigma = false;
  const AlignmentResult fixed = align(keyframe_of(scene), *target, options);
  EXPECT_EQ(fixed.sigma_scale, 1.0);
  EXPECT_LT(adapted.sigma_scale, 0.4);
  EXPECT_GE(adapted.sigma_scale, 0.99 * options.min_sigma_intensity / options.sigma_intensity);
  EXPECT_LT(pose_error(adapted.T_th, some_motion()).norm(),
            0.5 * pose_error(fixed.T_th, some_motion()).norm());
  EXPECT_LT(adapted.hessian_covariance.trace(), 0.3 * fixed.hessian_covariance.trace());
}

TEST(Aligner, RotationOnlyTurnsAboutTheTarget) {
  const PlaneScene scene;
  TrackingOptions options = finest();
  options.motion = MotionGroup::SO3;
  Vector6 xi = Vector6::Zero();
  xi.tail<3>() << 0.02, -0.03, 0.01;
  const AlignmentResult result = align(keyframe_of(scene), *scene.frame(se3_exp(xi)), options);
  ASSERT_EQ(result.status, AlignmentStatus::OK) << result.reason;
  EXPECT_LT(pose_error(result.T_th, se3_exp(xi)).norm(), 1e-4);
  EXPECT_EQ((result.T_th.topRightCorner<3, 1>().norm()), 0.0);
  EXPECT_EQ(result.information.row(0).norm(), 0.0);
  EXPECT_EQ(result.information_eigenvalues.size(), 3U);
}

// The target's depth in other units: T_th is then a similarity.
TEST(Aligner, SimilarityFindsTheScale) {
  const PlaneScene scene;
  TrackingOptions options = finest();
  options.motion = MotionGroup::SIM3;
  for (const double scale : {0.8, 1.25}) {
    Plane<float> image, D;
    scene.render(some_motion(), image, D);
    for (std::size_t i = 0; i < D.size(); ++i) D.data()[i] /= static_cast<float>(scale);
    const AlignmentResult result =
        align(keyframe_of(scene), *scene.frame_of(image, D, 1e-6), options);
    ASSERT_EQ(result.status, AlignmentStatus::OK) << result.reason;
    const double found = std::cbrt(result.T_th.topLeftCorner<3, 3>().determinant());
    EXPECT_NEAR(found, scale, 1e-3 * scale);
  }
}

TEST(Aligner, BrightnessDoesNotMoveThePose) {
  const PlaneScene scene;
  const Keyframe keyframe = keyframe_of(scene);
  Plane<float> image, D;
  scene.render(some_motion(), image, D);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = 1.2F * image.data()[i] - 7.0F;
  const auto target = scene.frame_of(image, D, 0.0);
  for (const AffineMode mode : {AffineMode::JOINT, AffineMode::CLOSED_FORM}) {
    TrackingOptions options = finest();
    options.affine.mode = mode;
    options.affine.prior_sigma_b = 1e3;
    options.affine.prior_sigma_a = 10.0;
    const AlignmentResult result = align(keyframe, *target, options);
    EXPECT_LT(pose_error(result.T_th, some_motion()).norm(), 5e-4) << to_string(mode);
    EXPECT_NEAR(std::exp(result.a), 1.0 / 1.2, 5e-3) << to_string(mode);
    EXPECT_NEAR(result.b, 7.0 / 1.2, 0.8) << to_string(mode);
  }
}

TEST(Aligner, ScaleOfTheWorldIsOnlyUnits) {
  const PlaneScene scene;
  PlaneScene large = scene;
  large.scale = 8.0;
  Matrix4 T = some_motion();
  const AlignmentResult a = align(keyframe_of(scene), *scene.frame(T));
  Matrix4 T_large = T;
  T_large.topRightCorner<3, 1>() *= large.scale;
  const Keyframe keyframe(large.frame(Matrix4::Identity(), 1e-6 / 64.0), {});
  const AlignmentResult b = align(keyframe, *large.frame(T_large));
  const Vector3 t = b.T_th.topRightCorner<3, 1>() / large.scale;
  EXPECT_LT((t - a.T_th.topRightCorner<3, 1>()).norm(), 1e-5);
  EXPECT_LT(((b.T_th - a.T_th).topLeftCorner<3, 3>().norm()), 1e-5);
  EXPECT_NEAR(b.residual_variance, a.residual_variance, 1e-3 * a.residual_variance);
  EXPECT_NEAR(b.information_eigenvalues[0], a.information_eigenvalues[0],
              1e-2 * a.information_eigenvalues[0]);
}

TEST(Aligner, ThreadsDoNotChangeABit) {
  PlaneScene scene;
  scene.width = 321;
  scene.height = 239;
  const Keyframe keyframe = keyframe_of(scene);
  const auto target = scene.frame(some_motion(), 1e-6);
  const AlignmentResult one = align(keyframe, *target);
  for (const int threads : {2, 3}) {
    TrackingOptions options = finest();
    options.lm.num_threads = threads;
    const AlignmentResult many = align(keyframe, *target, options);
    EXPECT_EQ(one.T_th, many.T_th);
    EXPECT_EQ(one.covariance, many.covariance);
    EXPECT_EQ(one.agreement, many.agreement);
    EXPECT_EQ(one.a, many.a);
  }
}

TEST(Aligner, TakesAnySize) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, {2, 2}, {3, 5}, {16, 16}, {17, 40}, {161, 119}, {320, 240}, {641, 479}}) {
    PlaneScene scene;
    scene.width = width;
    scene.height = height;
    const AlignmentResult result = align(keyframe_of(scene), *scene.frame(some_motion(), 1e-6));
    if (width * height < 64) {
      EXPECT_EQ(result.status, AlignmentStatus::TOO_FEW_POINTS);
    } else if (width > 100) {
      EXPECT_EQ(result.status, AlignmentStatus::OK) << result.reason;
    }
  }
}

// Twelve megapixels; the texture is a pattern of integers, the world a plane.
TEST(Aligner, TakesLargeImages) {
  PlaneScene scene;
  scene.width = 4000;
  scene.height = 3000;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(scene.width) * scene.height);
  for (int v = 0; v < scene.height; ++v) {
    for (int u = 0; u < scene.width; ++u) {
      const int wave = std::abs(u % 256 - 128) + std::abs(v % 320 - 160) / 2 + (u + v) % 1024 / 32;
      pixels[static_cast<std::size_t>(v) * scene.width + u] = static_cast<std::uint8_t>(wave);
    }
  }
  const ImageView image = {pixels.data(),
                           PixelType::UINT8,
                           scene.width,
                           scene.height,
                           1,
                           static_cast<std::size_t>(scene.width)};
  const auto frame = std::make_shared<Frame>(image, scene.camera());
  Plane<float> D(scene.width, scene.height);
  std::fill(D.data(), D.data() + D.size(), 0.5F);
  frame->set_depth(D.view(), D.view());
  KeyframeOptions points;
  points.max_points = 4000;
  const Keyframe keyframe(frame, points);
  AlignmentStart start;
  start.T_th = se3_exp(Vector6(Vector6::Constant(1e-3)));
  const AlignmentResult result = align(keyframe, *frame, TrackingOptions(), start);
  EXPECT_EQ(result.status, AlignmentStatus::OK) << result.reason;
  EXPECT_LT(pose_error(result.T_th, Matrix4::Identity()).norm(), 1e-4);
}

TEST(Aligner, TargetMayBeOfAnotherSize) {
  PlaneScene scene;
  const Keyframe keyframe = keyframe_of(scene);
  PlaneScene larger = scene;
  larger.width = 320;
  larger.height = 240;
  const AlignmentResult result = align(keyframe, *larger.frame(some_motion()));
  EXPECT_EQ(result.status, AlignmentStatus::OK) << result.reason;
  EXPECT_LT(pose_error(result.T_th, some_motion()).norm(), 2e-3);
}

TEST(Aligner, SaysWhyItFailed) {
  PlaneScene scene;
  Plane<float> image, D;
  scene.render(Matrix4::Identity(), image, D);
  const auto target = scene.frame(some_motion());
  const auto status_of = [&](const Plane<float>& I, const Plane<float>& depth) {
    return align(Keyframe(scene.frame_of(I, depth, 1e-6), {}), *target).status;
  };
  EXPECT_EQ(status_of(image, D), AlignmentStatus::OK);

  Plane<float> flat(scene.width, scene.height);
  std::fill(flat.data(), flat.data() + flat.size(), 100.0F);
  EXPECT_EQ(status_of(flat, D), AlignmentStatus::LOW_TEXTURE);

  Plane<float> nothing = D;
  std::fill(nothing.data(), nothing.data() + nothing.size(), NAN);
  EXPECT_EQ(status_of(image, nothing), AlignmentStatus::TOO_FEW_POINTS);

  // one direction of gradient only: the position along the stripes is not seen
  Plane<float> stripes = image;
  for (int v = 0; v < scene.height; ++v) {
    for (int u = 0; u < scene.width; ++u) {
      stripes.at(u, v) = static_cast<float>(128.0 + 60.0 * std::sin(0.3 * u));
    }
  }
  const Keyframe striped(scene.frame_of(stripes, D, 1e-6), {});
  EXPECT_EQ(align(striped, *scene.frame_of(stripes, D, 0.0)).status, AlignmentStatus::DEGENERATE);

  AlignmentStart behind;
  Vector6 half_turn = Vector6::Zero();
  half_turn[4] = 3.1;
  behind.T_th = se3_exp(half_turn);
  const Keyframe keyframe(scene.frame_of(image, D, 1e-6), {});
  EXPECT_EQ(align(keyframe, *target, finest(), behind).status, AlignmentStatus::LOST_OVERLAP);

  TrackingOptions bounded = finest();
  bounded.acceptance.max_rotation = 1e-3;
  EXPECT_EQ(align(keyframe, *target, bounded).status, AlignmentStatus::MOTION_BOUND);

  TrackingOptions hasty = finest();
  hasty.level_iterations = {1};
  hasty.coarsest_level = 0;
  hasty.lm.function_tolerance = 0.0;
  hasty.lm.parameter_tolerance = 0.0;
  EXPECT_EQ(align(keyframe, *scene.frame(some_motion(0.3)), hasty).status,
            AlignmentStatus::NOT_CONVERGED);
  EXPECT_EQ(align(keyframe, *scene.frame_of(flat, D, 0.0)).status, AlignmentStatus::DIVERGED);
}

TEST(Aligner, NoiseIsNeverOk) {
  const PlaneScene scene;
  const Keyframe keyframe = keyframe_of(scene);
  Plane<float> noise(scene.width, scene.height);
  for (int seed = 0; seed < 200; ++seed) {
    auto rng = test::make_rng("noise", static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < noise.size(); ++i) {
      noise.data()[i] = static_cast<float>(rng.uniform(0.0, 255.0));
    }
    const AlignmentResult result = align(keyframe, *scene.frame_of(noise, noise, 0.0));
    EXPECT_NE(result.status, AlignmentStatus::OK) << seed << " " << result.agreement;
  }
}

// Of starts far off, turned by more and more about each axis.
int num_found(bool rotation_first) {
  PlaneScene scene;
  scene.width = 320;
  scene.height = 240;
  scene.frequency = 2.0;
  const Keyframe keyframe = keyframe_of(scene);
  const auto target = scene.frame(some_motion());
  TrackingOptions options;
  options.rotation_first = rotation_first;
  Aligner aligner(options);
  int found = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int step = 1; step <= 8; ++step) {
      Vector6 xi;
      xi << 0.18, -0.15, 0.12, 0.0, 0.0, 0.0;
      xi[3 + axis] = (step % 2 == 0 ? 0.03 : -0.03) * step;
      const AlignmentResult result =
          aligner.align(keyframe, *target, {se3_exp(xi) * some_motion(), 0.0, 0.0, {}});
      found += pose_error(result.T_th, some_motion()).norm() < 5e-3 ? 1 : 0;
    }
  }
  return found;
}

TEST(Aligner, TurningFirstWidensTheBasin) { EXPECT_GT(num_found(true), num_found(false) + 2); }

TEST(Aligner, RefusesWhatIsNoMotion) {
  const PlaneScene scene;
  const Keyframe keyframe = keyframe_of(scene);
  const auto target = scene.frame(some_motion());
  AlignmentStart start;
  start.T_th(0, 0) = 2.0;
  EXPECT_THROW(align(keyframe, *target, finest(), start), OptionsError);
  start.T_th(0, 0) = NAN;
  EXPECT_THROW(align(keyframe, *target, finest(), start), OptionsError);
  TrackingOptions sim3 = finest();
  sim3.motion = MotionGroup::SIM3;
  EXPECT_THROW(align(keyframe, *target, sim3), OptionsError);
  EXPECT_THROW(Keyframe(target, {}), ShapeError);
}

}  // namespace
}  // namespace raylign
