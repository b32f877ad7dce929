// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_solver.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <stdexcept>

#include "raylign/base/error.h"
#include "raylign/ceres_backend/patch_problem.h"
#include "raylign/geometry/se3.h"
#include "support/patch_errors.h"
#include "support/patch_scenes.h"

namespace raylign::ceres_backend {
namespace {

using test::patch_case;
using test::patch_constraints;
using test::PatchCase;
using test::PatchSceneOptions;

PatchSolveOptions solve_options(LossType loss, double scale, LossScope scope) {
  PatchSolveOptions options;
  options.loss.type = loss;
  options.loss.scale = scale;
  options.scope = scope;
  options.lm.function_tolerance = 1e-12;
  options.lm.gradient_tolerance = 1e-12;
  return options;
}

bool same_bits(const void* a, const void* b, std::size_t size) {
  return std::memcmp(a, b, size) == 0;
}

struct Return {
  const char* name;
  PatchSceneOptions scene;
  PatchSolveOptions options;
};

std::vector<Return> returns() {
  std::vector<Return> cases;
  const auto add = [&](const char* name, LossType loss, double scale, LossScope scope) -> Return& {
    cases.push_back({name, {}, solve_options(loss, scale, scope)});
    return cases.back();
  };
  add("least_squares", LossType::TRIVIAL, 1.0, LossScope::PATCH);
  add("student_t", LossType::STUDENT_T, 3.0, LossScope::PIXEL).scene.brightness = true;
  add("huber_pixels", LossType::HUBER, 3.0, LossScope::PIXEL).scene.inverse_depth = true;
  Return& t = add("inverse_depth", LossType::HUBER, 10.0, LossScope::PATCH);
  t.scene.inverse_depth = true;
  t.scene.brightness = true;
  Return& stored = add("stored", LossType::CAUCHY, 5.0, LossScope::PIXEL);
  stored.scene.hosted = false;
  stored.scene.brightness = true;
  // the exercise: λ added to the diagonal as it is, unseen edges cost nothing
  Return& exercise = add("exercise", LossType::HUBER, 1.0, LossScope::PATCH);
  exercise.options.leaving = LeavingRule::ZERO;
  exercise.options.lm.jacobi_scaling = false;
  exercise.options.lm.min_diagonal = exercise.options.lm.max_diagonal = 1.0;
  exercise.options.lm.initial_lambda = 10.0;
  exercise.options.lm.max_num_iterations = 200;
  return cases;
}

class PatchReturn : public testing::TestWithParam<Return> {};

TEST_P(PatchReturn, ToTheTruthWithoutNoise) {
  const Return& c = GetParam();
  const PatchCase scenes = patch_case(c.scene);
  PatchScene scene = scenes.start;
  const Summary summary =
      solve_patches(scene, patch_constraints(scene, c.scene.brightness), c.options);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE) << summary.full_report();
  EXPECT_EQ(summary.backend, "ceres");
  EXPECT_LT(summary.final_cost, 1e-3 * summary.initial_cost);
  EXPECT_GT(test::centre_error(scenes.start, scenes.truth), 5e-3);
  EXPECT_LT(test::centre_error(scene, scenes.truth), 2e-4) << summary.full_report();
  EXPECT_LT(test::rotation_error(scene, scenes.truth), 1e-4);
  EXPECT_GT(test::point_error(scenes.start, scenes.truth), 5e-2);
  EXPECT_LT(test::point_error(scene, scenes.truth), 3e-3);
  EXPECT_LT((scene.brightness.col(0) - scenes.truth.brightness.col(0)).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((scene.brightness.col(1) - scenes.truth.brightness.col(1)).cwiseAbs().maxCoeff(), 0.1);
}

INSTANTIATE_TEST_SUITE_P(All, PatchReturn, testing::ValuesIn(returns()), [](const auto& test_case) {
  return test_case.param.name;
});

TEST(PatchSolver, HoldsWhatIsHeldBitByBit) {
  PatchSceneOptions scene_options;
  scene_options.brightness = true;
  const PatchCase scenes = patch_case(scene_options);
  PatchScene scene = scenes.start;
  PatchConstraints held = patch_constraints(scene, true, true);
  held.poses[2].translation = {false, true, false};
  held.poses[3].rotation = true;
  held.brightness[1] = {true, false};
  held.intrinsics[0] = {false, true, true, false};
  held.points.assign(static_cast<std::size_t>(scene.num_points()), false);
  held.points[7] = true;
  const Summary summary =
      solve_patches(scene, held, solve_options(LossType::HUBER, 3.0, LossScope::PATCH));
  EXPECT_TRUE(summary.is_usable());
  EXPECT_GT(summary.num_accepted, 3);
  const PatchScene& start = scenes.start;
  for (const int i : {0, 4}) {
    EXPECT_TRUE(same_bits(&scene.poses[i].q, &start.poses[i].q, sizeof(Quaternion)));
    EXPECT_TRUE(same_bits(&scene.poses[i].t, &start.poses[i].t, sizeof(Vector3)));
  }
  EXPECT_EQ(scene.poses[2].t.y(), start.poses[2].t.y());
  EXPECT_NE(scene.poses[2].t.x(), start.poses[2].t.x());
  EXPECT_TRUE(same_bits(&scene.poses[3].q, &start.poses[3].q, sizeof(Quaternion)));
  EXPECT_NE(scene.poses[3].t, start.poses[3].t);
  EXPECT_EQ(scene.brightness(1, 0), start.brightness(1, 0));
  EXPECT_NE(scene.brightness(1, 1), start.brightness(1, 1));
  EXPECT_EQ(scene.intrinsics(0, 1), start.intrinsics(0, 1));
  EXPECT_EQ(scene.intrinsics(0, 2), start.intrinsics(0, 2));
  EXPECT_NE(scene.intrinsics(0, 0), start.intrinsics(0, 0));
  EXPECT_EQ(scene.points.row(7), start.points.row(7));
  EXPECT_NE(scene.points.row(8), start.points.row(8));
}

TEST(PatchSolver, EverythingHeldComesBackAsItWas) {
  const PatchCase scenes = patch_case();
  PatchScene scene = scenes.start;
  PatchConstraints held = patch_constraints(scene);
  held.poses.assign(5, {{true, true, true}, true});
  held.points.assign(40, true);
  const Summary summary = solve_patches(scene, held, {});
  EXPECT_TRUE(summary.is_usable());
  EXPECT_GT(summary.initial_cost, 0.0);
  EXPECT_EQ(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(scene.points, scenes.start.points);
}

TEST(PatchSolver, PriorsPullAndCountInTheCost) {
  PatchSceneOptions scene_options;
  scene_options.brightness = true;
  const PatchCase scenes = patch_case(scene_options);
  PatchScene scene = scenes.start;
  PatchConstraints held = patch_constraints(scene, true);
  const PatchSolveOptions options = solve_options(LossType::HUBER, 3.0, LossScope::PATCH);
  Matrix4 T = Matrix4::Identity();  // far from the images' own answer
  T.topLeftCorner<3, 3>() = scenes.truth.poses[2].q.toRotationMatrix();
  T.topRightCorner<3, 1>() = scenes.truth.poses[2].t + Vector3(0.02, 0.0, 0.0);
  held.pose_priors.push_back({2, T, Matrix6::Identity() * 1e14});
  const Vector3 X = scenes.truth.points.row(5).transpose() + Vector3(0.0, 0.0, 0.05);
  held.point_priors.push_back({5, X, Matrix3::Identity() * 1e14});
  held.weight_b = 1e14;
  const Summary summary = solve_patches(scene, held, options);
  EXPECT_TRUE(summary.is_usable());
  EXPECT_LT((scene.poses[2].t - T.topRightCorner<3, 1>()).norm(), 1e-5);
  EXPECT_LT((scene.points.row(5).transpose() - X).norm(), 1e-5);
  EXPECT_LT(scene.brightness.bottomRows(4).col(1).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_GT(scene.brightness.col(0).cwiseAbs().maxCoeff(), 1e-2);

  // ½ Λ ξ² and nothing else, where the images have nothing to say
  PatchScene alone = scenes.truth;
  alone.edges.clear();
  alone.starts.assign(41, 0);
  alone.brightness.setZero();
  PatchConstraints one = patch_constraints(alone, true);
  Vector6 xi;
  xi << 0.01, 0.0, -0.02, 0.0, 0.03, 0.0;
  Matrix4 here = Matrix4::Identity();
  here.topLeftCorner<3, 3>() = alone.poses[2].q.toRotationMatrix();
  here.topRightCorner<3, 1>() = alone.poses[2].t;
  one.pose_priors.push_back({2, se3_inverse(se3_exp(xi)) * here, Matrix6::Identity() * 5.0});
  const Summary prior_only = solve_patches(alone, one, options);
  EXPECT_NEAR(prior_only.initial_cost, 2.5 * xi.squaredNorm(), 1e-12);
  EXPECT_LT(prior_only.final_cost, 1e-12);
}

class Leaving : public testing::TestWithParam<LossScope> {};

TEST_P(Leaving, KeepsTheCostOfTheStartOrCostsNothing) {
  PatchScene start = patch_case().start;
  const PatchConstraints held = patch_constraints(start);
  for (const LeavingRule rule : {LeavingRule::KEEP_COST, LeavingRule::ZERO}) {
    PatchScene scene = start;
    PatchSolveOptions options = solve_options(LossType::HUBER, 2.0, GetParam());
    options.leaving = rule;
    PatchProblem problem(scene, held, options);
    double* point = problem.point_blocks()[3];
    std::vector<double> gradient;
    double before = 0.0;
    double after = 0.0;
    problem.ceres_problem().Evaluate({}, &before, nullptr, &gradient, nullptr);
    const double of_point = [&] {
      PatchScene rest = start;
      const auto first = rest.edges.begin() + rest.starts[3];
      rest.edges.erase(first, first + (rest.starts[4] - rest.starts[3]));
      const std::int64_t count = rest.starts[4] - rest.starts[3];
      for (std::size_t p = 4; p < rest.starts.size(); ++p) rest.starts[p] -= count;
      PatchSolveOptions none = options;
      none.lm.max_num_iterations = 0;
      return before - solve_patches(rest, held, none).initial_cost;
    }();
    ASSERT_GT(of_point, 1.0);
    point[0] += 100.0;
    problem.ceres_problem().Evaluate({}, &after, nullptr, &gradient, nullptr);
    EXPECT_NEAR(after, rule == LeavingRule::ZERO ? before - of_point : before, 1e-9 * before);
  }
}

TEST_P(Leaving, OnceOutPullsNoMoreWhereItCostsNothing) {
  for (const LeavingRule rule : {LeavingRule::KEEP_COST, LeavingRule::ZERO}) {
    PatchScene scene = patch_case().start;
    const PatchConstraints held = patch_constraints(scene);
    PatchSolveOptions options = solve_options(LossType::HUBER, 2.0, GetParam());
    options.leaving = rule;
    PatchProblem problem(scene, held, options);
    double& x = problem.point_blocks()[3][0];
    const double inside = x;
    double before = 0.0;
    double cost = 0.0;
    std::vector<double> gradient_before, gradient;
    problem.ceres_problem().Evaluate({}, &before, nullptr, &gradient_before, nullptr);
    x += 100.0;
    problem.ceres_problem().Evaluate({}, &cost, nullptr, nullptr, nullptr);
    x = inside;
    problem.ceres_problem().Evaluate({}, &cost, nullptr, &gradient, nullptr);
    EXPECT_EQ(cost, before);
    EXPECT_EQ(gradient == gradient_before, rule == LeavingRule::KEEP_COST);
  }
}

TEST_P(Leaving, TooManyAtOnceAreRefusedWhereCostsAreKept) {
  for (const LeavingRule rule : {LeavingRule::KEEP_COST, LeavingRule::ZERO}) {
    PatchScene scene = patch_case().start;
    const PatchConstraints held = patch_constraints(scene);
    PatchSolveOptions options = solve_options(LossType::HUBER, 2.0, GetParam());
    options.leaving = rule;
    PatchProblem problem(scene, held, options);
    ceres::Problem& ceres_problem = problem.ceres_problem();
    std::vector<double> gradient;
    double cost = 0.0;
    EXPECT_TRUE(ceres_problem.Evaluate({}, &cost, nullptr, &gradient, nullptr));
    problem.point_blocks()[3][0] += 100.0;  // one of 40 points: less than 5 % of the edges
    EXPECT_TRUE(ceres_problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
    for (int p = 4; p < 8; ++p) problem.point_blocks()[p][0] += 100.0;
    EXPECT_EQ(ceres_problem.Evaluate({}, &cost, nullptr, nullptr, nullptr),
              rule == LeavingRule::ZERO);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Leaving, testing::Values(LossScope::PATCH, LossScope::PIXEL));

TEST(PatchSolver, EdgesUnseenAtTheStartTakeNoPart) {
  const PatchScene start = patch_case().start;
  const PatchConstraints held = patch_constraints(start);
  PatchSolveOptions options = solve_options(LossType::HUBER, 2.0, LossScope::PATCH);
  PatchScene scene = start;
  scene.points.row(3) << 100.0, 0.0, 2.0;
  const Summary summary = solve_patches(scene, held, options);
  EXPECT_TRUE(summary.is_usable());
  EXPECT_EQ(scene.points(3, 0), 100.0);
}

TEST(PatchSolver, CallbackStopsAndThrowsWithTheBestStateInTheScene) {
  const PatchScene start = patch_case().start;
  const PatchConstraints held = patch_constraints(start);
  const PatchSolveOptions options = solve_options(LossType::HUBER, 2.0, LossScope::PATCH);
  PatchScene scene = start;
  double cost = 0.0;
  const auto stop = [&](const IterationSummary& row) {
    cost = row.cost;
    return row.iteration == 3 ? CallbackAction::STOP : CallbackAction::CONTINUE;
  };
  const Summary summary = solve_patches(scene, held, options, stop);
  EXPECT_EQ(summary.termination, Termination::USER_STOPPED);
  PatchSolveOptions none = options;
  none.lm.max_num_iterations = 0;
  EXPECT_DOUBLE_EQ(solve_patches(scene, held, none).initial_cost, cost);

  scene = start;
  const auto fail = [&](const IterationSummary& row) -> CallbackAction {
    cost = row.cost;
    if (row.iteration == 3) throw std::runtime_error("stop");
    return CallbackAction::CONTINUE;
  };
  EXPECT_THROW(solve_patches(scene, held, options, fail), std::runtime_error);
  EXPECT_DOUBLE_EQ(solve_patches(scene, held, none).initial_cost, cost);
}

TEST(PatchSolver, BadStartsFailAndBadShapesThrow) {
  const PatchScene start = patch_case().start;
  const PatchConstraints held = patch_constraints(start);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto termination = [&](const auto& spoil) {
    PatchScene scene = start;
    spoil(scene);
    const Summary summary = solve_patches(scene, held, {});
    EXPECT_FALSE(summary.message.empty());
    return summary.termination;
  };
  EXPECT_EQ(termination([&](PatchScene& s) { s.brightness(2, 0) = nan; }), Termination::FAILURE);
  EXPECT_EQ(termination([&](PatchScene& s) { s.patches[20] = static_cast<float>(nan); }),
            Termination::FAILURE);
  // what is nowhere seen does no harm
  EXPECT_NE(termination([&](PatchScene& s) { s.points(3, 1) = nan; }), Termination::FAILURE);
  EXPECT_NE(termination([&](PatchScene& s) { s.poses[2].t.x() = nan; }), Termination::FAILURE);

  const auto throws_shape = [&](const auto& spoil) {
    PatchScene scene = start;
    PatchConstraints constraints = held;
    spoil(scene, constraints);
    EXPECT_THROW(solve_patches(scene, constraints, {}), ShapeError);
  };
  throws_shape([](PatchScene& s, PatchConstraints&) { s.poses.pop_back(); });
  throws_shape([](PatchScene&, PatchConstraints& c) { c.poses.pop_back(); });
  throws_shape([](PatchScene&, PatchConstraints& c) { c.brightness.clear(); });
  throws_shape([](PatchScene&, PatchConstraints& c) { c.intrinsics.push_back({}); });
  throws_shape([](PatchScene&, PatchConstraints& c) { c.points.assign(3, true); });
  throws_shape([](PatchScene&, PatchConstraints& c) { c.pose_priors.emplace_back().image = 5; });
  throws_shape([](PatchScene&, PatchConstraints& c) { c.point_priors.emplace_back().point = -1; });
  PatchScene scene = start;
  PatchConstraints constraints = held;
  constraints.weight_a = -1.0;
  EXPECT_THROW(solve_patches(scene, constraints, {}), OptionsError);
  PatchSolveOptions options;
  options.max_leaving_share = 2.0;
  EXPECT_THROW(solve_patches(scene, held, options), OptionsError);
}

}  // namespace
}  // namespace raylign::ceres_backend
