// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "raylign/base/error.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "support/autodiff_bal.h"
#include "support/small_problem.h"

namespace raylign {
namespace {

BundleOptions parity_options() {
  BundleOptions options;
  options.backend = Backend::CERES;
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

// Every field, with values that are nobody's default: a forgotten line shows.
TEST(ToCeres, CarriesEveryOption) {
  BundleOptions options;
  LmOptions& lm = options.lm;
  lm.max_num_iterations = 7;
  lm.max_solver_time_s = 12.5;
  lm.function_tolerance = 1e-3;
  lm.gradient_tolerance = 1e-4;
  lm.parameter_tolerance = 1e-5;
  lm.initial_lambda = 0.25;
  lm.min_lambda = 0.125;
  lm.max_lambda = 64.0;
  lm.min_relative_decrease = 0.01;
  lm.min_diagonal = 1e-7;
  lm.max_diagonal = 1e7;
  lm.max_num_consecutive_invalid_steps = 9;
  lm.jacobi_scaling = false;
  lm.num_threads = 1;
  options.linear_solver.type = LinearSolverType::ITERATIVE_SCHUR;
  options.linear_solver.preconditioner = Preconditioner::CLUSTER_JACOBI;
  options.linear_solver.explicit_schur = true;
  options.linear_solver.max_num_iterations = 77;
  options.linear_solver.forcing_tolerance = 0.03;
  const ceres::Solver::Options out = ceres_backend::to_ceres(options);
  EXPECT_EQ(out.max_num_iterations, 7);
  EXPECT_EQ(out.max_solver_time_in_seconds, 12.5);
  EXPECT_EQ(out.function_tolerance, 1e-3);
  EXPECT_EQ(out.gradient_tolerance, 1e-4);
  EXPECT_EQ(out.parameter_tolerance, 1e-5);
  EXPECT_EQ(out.initial_trust_region_radius, 4.0);
  EXPECT_EQ(out.max_trust_region_radius, 8.0);
  EXPECT_EQ(out.min_trust_region_radius, 1.0 / 64.0);
  EXPECT_EQ(out.min_relative_decrease, 0.01);
  EXPECT_EQ(out.min_lm_diagonal, 1e-7);
  EXPECT_EQ(out.max_lm_diagonal, 1e7);
  EXPECT_EQ(out.max_num_consecutive_invalid_steps, 9);
  EXPECT_FALSE(out.jacobi_scaling);
  EXPECT_EQ(out.num_threads, 1);
  EXPECT_EQ(out.linear_solver_type, ceres::ITERATIVE_SCHUR);
  EXPECT_EQ(out.preconditioner_type, ceres::CLUSTER_JACOBI);
  EXPECT_TRUE(out.use_explicit_schur_complement);
  EXPECT_EQ(out.max_linear_solver_iterations, 77);
  EXPECT_EQ(out.eta, 0.03);
  std::string error;
  options = BundleOptions{};
  EXPECT_TRUE(ceres_backend::to_ceres(options).IsValid(&error)) << error;
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
