// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <string>

#include "raylign/ceres_backend/patch_solver.h"
#include "raylign/geometry/se3.h"
#include "raylign/photometric/native/solve.h"
#include "support/patch_errors.h"
#include "support/patch_scenes.h"

namespace raylign {
namespace {

using test::patch_case;
using test::PatchCase;
using test::PatchSceneOptions;

// Both engines minimise the same function with the same steps: T2 of the specification.
struct Case {
  std::string name;
  Loss loss = {LossType::STUDENT_T, 3.0, 5.0};
  LossScope scope = LossScope::PIXEL;
  PatchSceneOptions scene = {};
  bool brightness = true;
  bool intrinsics = false;
  std::function<void(PatchScene&, PatchConstraints&, PatchSolveOptions&)> change = {};
};

// With fewer, float rounding of the native kernel's cost moves the optimum by more than the mark.
constexpr int kNumPoints = 300;

PatchSceneOptions scene_with(const std::function<void(PatchSceneOptions&)>& change) {
  PatchSceneOptions options;
  options.brightness = true;
  options.sigma = 1.0;
  options.num_points = kNumPoints;
  change(options);
  return options;
}

Matrix4 matrix(const PatchPose& pose) {
  Matrix4 T = Matrix4::Identity();
  T.topLeftCorner<3, 3>() = pose.q.toRotationMatrix();
  T.topRightCorner<3, 1>() = pose.t;
  return T;
}

void add_priors(PatchScene& scene, PatchConstraints& held, PatchSolveOptions& /*options*/) {
  held.weight_a = 200.0;
  held.weight_b = 0.3;
  Matrix6 information = Matrix6::Identity() * 1e5;
  information(1, 3) = information(3, 1) = 3e4;
  Vector6 xi;
  xi << 0.01, -0.004, 0.006, 0.003, -0.005, 0.002;
  held.pose_priors.push_back({1, se3_exp(xi) * matrix(scene.poses[1]), information});
  Matrix3 of_point = Matrix3::Identity() * 1e4;
  of_point(0, 2) = of_point(2, 0) = 2e3;
  Vector3 value = scene.points.row(5).transpose();
  value[0] += 0.02;
  held.point_priors.push_back({5, value, of_point});
}

void hold_parts(PatchScene& scene, PatchConstraints& held, PatchSolveOptions& /*options*/) {
  held.poses[2].translation = {false, true, false};
  held.poses[3].rotation = true;
  held.brightness[1] = {true, false};
  held.brightness[2] = {false, true};
  held.points.assign(static_cast<std::size_t>(scene.num_points()), false);
  held.points[4] = held.points[11] = true;
  scene.edges[6].mask = 0x7ff3u;
}

// With all of them free a turn of a camera is almost a shift of its principal point.
void hold_most_intrinsics(PatchScene& /*scene*/,
                          PatchConstraints& held,
                          PatchSolveOptions& /*options*/) {
  for (auto& row : held.intrinsics) row = {false, false, true, true};
  held.intrinsics[2] = {true, false, true, true};
}

void as_the_exercise(PatchScene& /*scene*/, PatchConstraints& held, PatchSolveOptions& options) {
  held.poses.assign(5, {});
  options.leaving = LeavingRule::ZERO;
  options.lm.jacobi_scaling = false;
  options.lm.min_diagonal = options.lm.max_diagonal = 1.0;
  options.lm.initial_lambda = 500.0;
}

std::vector<Case> cases() {
  const auto plain = scene_with([](auto&) {});
  const auto inverse = scene_with([](auto& o) { o.inverse_depth = true; });
  const auto stored = scene_with([](auto& o) { o.hosted = false; });
  const auto each = scene_with([](auto& o) { o.intrinsics_per_image = true; });
  const auto spread = scene_with([](auto& o) {
    o.pattern = PatchPattern::spread8();
    o.num_points = 2 * kNumPoints;
  });
  const auto coarse = scene_with([](auto& o) {
    o.level = 1;
    o.width = 320;
    o.height = 240;
  });
  const auto bilinear =
      scene_with([](auto& o) { o.interpolation = SampleInterpolation::BILINEAR; });
  const auto both = scene_with([](auto& o) { o.noise_ratio = 0.76; });
  const auto both_inverse = scene_with([](auto& o) {
    o.noise_ratio = 0.76;
    o.inverse_depth = true;
  });
  const Loss t = {LossType::STUDENT_T, 3.0, 5.0};
  const Loss huber = {LossType::HUBER, 2.0, 5.0};
  const Loss patch_huber = {LossType::HUBER, 8.0, 5.0};
  constexpr LossScope kPixel = LossScope::PIXEL;
  constexpr LossScope kPatch = LossScope::PATCH;
  return {{"StudentT", t, kPixel, plain},
          {"Huber", huber, kPixel, plain},
          {"Cauchy", {LossType::CAUCHY, 4.0, 5.0}, kPixel, plain},
          {"LeastSquares", {}, kPatch, plain},
          {"PatchHuber", patch_huber, kPatch, plain},
          {"NoBrightness", huber, kPixel, scene_with([](auto& o) { o.brightness = false; }), false},
          {"Stored", t, kPixel, stored},
          {"InverseDepth", t, kPixel, inverse},
          {"InverseDepthPatchHuber", patch_huber, kPatch, inverse},
          {"Level1", t, kPixel, coarse},
          {"Spread8", t, kPixel, spread},
          {"NoiseOfBoth", t, kPixel, both},
          {"NoiseOfBothPatchHuber", patch_huber, kPatch, both_inverse},
          {"Bilinear", t, kPixel, bilinear},
          {"SharedIntrinsics", t, kPixel, plain, true, true},
          {"IntrinsicsPerImage", t, kPixel, each, true, true, hold_most_intrinsics},
          {"Priors", t, kPixel, plain, true, false, add_priors},
          {"InverseDepthPriors", t, kPixel, inverse, true, false, add_priors},
          {"Held", t, kPixel, plain, true, false, hold_parts},
          {"InverseDepthHeld", t, kPixel, inverse, true, false, hold_parts},
          {"Exercise", {LossType::HUBER, 1.0, 5.0}, kPatch, stored, false, false, as_the_exercise}};
}

class Parity : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const Case& c = GetParam();
    start_ = patch_case(c.scene).start;
    held_ = test::patch_constraints(start_, c.brightness, c.intrinsics);
    options_.loss = c.loss;
    options_.scope = c.scope;
    options_.lm.function_tolerance = 1e-13;
    options_.lm.parameter_tolerance = 1e-13;
    options_.lm.max_num_iterations = 100;
    if (c.change) c.change(start_, held_, options_);
  }

  PatchScene start_;
  PatchConstraints held_;
  PatchSolveOptions options_;
};

// What a solve changed: poses as tangents, then the rest as numbers.
Eigen::VectorXd step_of(const PatchScene& before, const PatchScene& after) {
  std::vector<double> step;
  for (std::size_t i = 0; i < before.poses.size(); ++i) {
    const Vector6 xi = se3_log(matrix(after.poses[i]) * se3_inverse(matrix(before.poses[i])));
    step.insert(step.end(), xi.data(), xi.data() + 6);
  }
  const auto add = [&](const auto& a, const auto& b) {
    for (Eigen::Index k = 0; k < a.size(); ++k) step.push_back(b.data()[k] - a.data()[k]);
  };
  add(before.points, after.points);
  add(before.brightness, after.brightness);
  add(before.intrinsics, after.intrinsics);
  return Eigen::Map<Eigen::VectorXd>(step.data(), static_cast<Eigen::Index>(step.size()));
}

TEST_P(Parity, SameCostAndSameFirstStep) {
  options_.lm.max_num_iterations = 1;
  PatchScene native = start_;
  PatchScene ceres = start_;
  const Summary a = native::solve_patches(native, held_, options_);
  const Summary b = ceres_backend::solve_patches(ceres, held_, options_);
  EXPECT_NEAR(a.initial_cost, b.initial_cost, 1e-6 * b.initial_cost);
  ASSERT_EQ(a.num_accepted, 1) << a.full_report();
  ASSERT_EQ(b.num_accepted, 1) << b.full_report();
  EXPECT_NEAR(a.final_cost, b.final_cost, 1e-5 * b.final_cost);
  EXPECT_EQ(a.num_effective_parameters, b.num_effective_parameters);
  const Eigen::VectorXd of_native = step_of(start_, native);
  const Eigen::VectorXd of_ceres = step_of(start_, ceres);
  EXPECT_LT((of_native - of_ceres).norm(), 1e-5 * of_ceres.norm());
}

TEST_P(Parity, SameOptimum) {
  const Case& c = GetParam();
  if (c.name == "Exercise") GTEST_SKIP() << "has no optimum that an engine reaches";
  PatchScene native = start_;
  PatchScene ceres = start_;
  const Summary a = native::solve_patches(native, held_, options_);
  const Summary b = ceres_backend::solve_patches(ceres, held_, options_);
  EXPECT_TRUE(a.is_usable() && b.is_usable());
  EXPECT_LT(b.final_cost, 0.2 * b.initial_cost);
  EXPECT_NEAR(a.final_cost, b.final_cost, 1e-6 * b.final_cost);
  EXPECT_LT(test::centre_error(native, ceres), 1e-6) << a.full_report() << b.full_report();
  EXPECT_LT(test::rotation_error(native, ceres), 1e-6);
}

bool same_bits(const PatchScene& a, const PatchScene& b) {
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    if (a.poses[i].q.coeffs() != b.poses[i].q.coeffs() || a.poses[i].t != b.poses[i].t)
      return false;
  }
  return a.points == b.points && a.brightness == b.brightness && a.intrinsics == b.intrinsics;
}

TEST_P(Parity, SameBitsOnAnyNumberOfThreads) {
  options_.lm.max_num_iterations = 4;
  PatchScene first = start_;
  native::solve_patches(first, held_, options_);
  EXPECT_FALSE(same_bits(first, start_));
  for (const int num_threads : {1, 2, 4}) {
    options_.lm.num_threads = num_threads;
    PatchScene scene = start_;
    EXPECT_TRUE(native::solve_patches(scene, held_, options_).deterministic);
    EXPECT_TRUE(same_bits(scene, first)) << num_threads;
  }
}

INSTANTIATE_TEST_SUITE_P(T2, Parity, testing::ValuesIn(cases()), [](const auto& test_case) {
  return test_case.param.name;
});

}  // namespace
}  // namespace raylign
