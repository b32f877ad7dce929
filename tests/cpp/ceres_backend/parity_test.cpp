// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "raylign/base/error.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "support/autodiff_bal.h"
#include "support/small_problem.h"

namespace raylign {
namespace {

BundleOptions parity_options() {
  BundleOptions options;
  options.pose_parametrization = PoseParametrization::ANGLE_AXIS;
  options.linear_solver.type = LinearSolverType::DENSE_SCHUR;
  options.lm.function_tolerance = 1e-12;
  return options;
}

// Hand-written Jacobians, blocks of 6 + 3 + 3 and our summary must walk the very path that Ceres'
// example walks with automatic differentiation and blocks of 9 + 3.
TEST(Parity, AngleAxisFollowsTheAutodiffTrajectoryCostByCost) {
  const BundleOptions options = parity_options();
  BalProblem ours = test::small_problem();
  BalProblem reference = ours;
  const Summary summary = adjust(ours, BundleConfig{}, options);
  const ceres::Solver::Summary expected =
      test::AutodiffBal(reference).solve(ceres_backend::to_ceres(options));
  ASSERT_GE(summary.iterations.size(), 5u);
  ASSERT_EQ(summary.iterations.size(), expected.iterations.size());
  for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
    const double cost = expected.iterations[i].cost;
    EXPECT_NEAR(summary.iterations[i].cost, cost, 1e-9 * cost) << "iteration " << i;
    EXPECT_NEAR(summary.iterations[i].lambda * expected.iterations[i].trust_region_radius, 1.0,
                1e-6);
  }
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-10 * expected.final_cost);
}

TEST(Parity, SchurSolversAgreeOnTheFirstStep) {
  BundleOptions options = parity_options();
  options.lm.max_num_iterations = 1;
  std::vector<double> costs;
  for (const auto type : {LinearSolverType::DENSE_SCHUR, LinearSolverType::SPARSE_SCHUR,
                          LinearSolverType::DENSE_NORMAL_CHOLESKY}) {
    options.linear_solver.type = type;
    BalProblem problem = test::small_problem();
    costs.push_back(adjust(problem, BundleConfig{}, options).final_cost);
  }
  EXPECT_NEAR(costs[1], costs[0], 1e-10 * costs[0]);
  EXPECT_NEAR(costs[2], costs[0], 1e-10 * costs[0]);
}

TEST(Adjust, LeavesTheProblemAloneWhenItFails) {
  BalProblem problem = test::small_problem();
  problem.points(3, 0) = std::numeric_limits<double>::infinity();
  const BalProblem before = problem;
  const Summary summary = adjust(problem, BundleConfig{}, BundleOptions{});
  EXPECT_EQ(summary.termination, Termination::FAILURE);
  EXPECT_NE(summary.message.find("point 3"), std::string::npos) << summary.message;
  EXPECT_TRUE(problem == before);
}

TEST(Adjust, PassesExceptionsOfTheCallbackThrough) {
  BalProblem problem = test::small_problem();
  const BalProblem before = problem;
  const auto callback = [](const IterationSummary&) -> CallbackAction {
    throw std::logic_error("mine");
  };
  EXPECT_THROW(adjust(problem, BundleConfig{}, BundleOptions{}, callback), std::logic_error);
  EXPECT_TRUE(problem == before);
}

TEST(Adjust, RefusesInvalidArguments) {
  BalProblem problem = test::small_problem();
  BundleOptions options;
  options.lm.initial_lambda = -1.0;
  EXPECT_THROW(adjust(problem, BundleConfig{}, options), OptionsError);
  BundleConfig config;
  config.constant_points = {1000};
  EXPECT_THROW(adjust(problem, config, BundleOptions{}), OptionsError);
  problem.point_index[0] = -1;
  EXPECT_THROW(adjust(problem, BundleConfig{}, BundleOptions{}), ShapeError);
}

}  // namespace
}  // namespace raylign
