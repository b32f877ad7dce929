// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/jacobian_table.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <utility>

#include "bundle/reference.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/bundle/native/schur_system.h"
#include "raylign/parametrization/constants.h"
#include "raylign/synthetic/bal.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

BalProblem far_problem() {
  SyntheticBalOptions options;
  options.num_cameras = 12;
  options.num_points = 400;
  options.far_fraction = 0.3;
  options.seed = 5;
  return synthetic_bal(options).problem;
}

BundleOptions options_of(JacobianStorage storage, int num_threads = 1) {
  BundleOptions options;
  options.backend = Backend::NATIVE;
  options.jacobian_storage = storage;
  options.lm.num_threads = num_threads;
  options.lm.function_tolerance = 1e-12;
  options.lm.max_num_iterations = 100;
  return options;
}

struct Linearized {
  Linearized(const BalProblem& problem, JacobianStorage storage)
      : native(BundleScene(problem),
               resolve_constants(BundleScene(problem), {}),
               options_of(storage)) {
    state = native.linearize();
  }
  Eigen::MatrixXd schur(double lambda) {
    const SolverContext context{native.layout(), native.cameras(), native.pool()};
    SchurSystem system(context, SchurPattern(context.layout, moving_cameras(context.cameras)));
    system.form(native.damped(lambda));
    return test::dense_schur(system);
  }
  ReprojectionProblem native;
  LmState state;
};

TEST(FloatJacobian, GradientIsNotRounded) {
  const BalProblem problem = test::small_problem();
  const Linearized exact(problem, JacobianStorage::DOUBLE);
  const Linearized rounded(problem, JacobianStorage::FLOAT);
  EXPECT_EQ(rounded.state.cost, exact.state.cost);
  const double gradient = exact.state.gradient_max_norm;
  EXPECT_NEAR(rounded.state.gradient_max_norm, gradient, 1e-13 * gradient);
}

TEST(FloatJacobian, SchurComplementIsCloseAndPositive) {
  const BalProblem problem = far_problem();
  Linearized exact(problem, JacobianStorage::DOUBLE);
  Linearized rounded(problem, JacobianStorage::FLOAT);
  for (const auto& [lambda, tolerance] : {std::pair(1e-4, 1e-6), std::pair(1e-8, 1e-5)}) {
    const Eigen::MatrixXd S = exact.schur(lambda);
    const Eigen::MatrixXd S_rounded = rounded.schur(lambda);
    EXPECT_LE((S_rounded - S).norm(), tolerance * S.norm());
    EXPECT_GT((S_rounded - S).norm(), 0.0);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(S_rounded, Eigen::EigenvaluesOnly);
    EXPECT_GE(solver.eigenvalues()[0], -1e-14 * S.norm());
  }
}

TEST(FloatJacobian, ReachesTheSameMinimum) {
  BalProblem exact = test::small_problem();
  BalProblem rounded = exact;
  const Summary reference = adjust(exact, {}, options_of(JacobianStorage::DOUBLE));
  const Summary summary = adjust(rounded, {}, options_of(JacobianStorage::FLOAT));
  EXPECT_EQ(reference.jacobian_storage, "double");
  EXPECT_EQ(summary.jacobian_storage.substr(0, 5), "float");
  EXPECT_NEAR(summary.final_cost, reference.final_cost, 1e-9 * reference.final_cost);
}

TEST(FloatJacobian, SameBitsForAnyNumberOfThreads) {
  const BalProblem start = far_problem();
  BalProblem one = start;
  BalProblem two = start;
  adjust(one, {}, options_of(JacobianStorage::FLOAT, 1));
  adjust(two, {}, options_of(JacobianStorage::FLOAT, 2));
  EXPECT_EQ(one.cameras, two.cameras);
  EXPECT_EQ(one.points, two.points);
}

TEST(FloatJacobian, IsTakenAboveAMillionObservations) {
  EXPECT_FALSE(JacobianTable(JacobianStorage::AUTO, true, 1'000'000).is_rounded());
  EXPECT_TRUE(JacobianTable(JacobianStorage::AUTO, true, 1'000'001).is_rounded());
  EXPECT_FALSE(JacobianTable(JacobianStorage::DOUBLE, false, 1'000'001).is_rounded());
  EXPECT_TRUE(JacobianTable(JacobianStorage::FLOAT, false, 1).is_rounded());
}

TEST(NoJacobian, IsTakenForLeastSquares) {
  JacobianTable none(JacobianStorage::AUTO, false, 1'000'001);
  EXPECT_FALSE(none.is_stored());
  EXPECT_FALSE(none.wants_double());
  EXPECT_EQ(none.view().exact, nullptr);
  EXPECT_EQ(none.view().rounded, nullptr);
  EXPECT_EQ(none.description(), "none");
  for (const auto wanted : {JacobianStorage::DOUBLE, JacobianStorage::FLOAT}) {
    EXPECT_TRUE(JacobianTable(wanted, false, 1).is_stored());
  }
}

// J computed again is the J of the table, in every pass and product.
TEST(NoJacobian, TakesTheStepsOfTheTable) {
  for (const bool explicit_schur : {false, true}) {
    for (const auto type : {LinearSolverType::DENSE_SCHUR, LinearSolverType::ITERATIVE_SCHUR}) {
      BundleOptions options = options_of(JacobianStorage::AUTO);
      options.linear_solver.type = type;
      options.linear_solver.explicit_schur =
          explicit_schur && type == LinearSolverType::ITERATIVE_SCHUR;
      BalProblem none = far_problem();
      BalProblem stored = none;
      const Summary summary = adjust(none, {}, options);
      options.jacobian_storage = JacobianStorage::DOUBLE;
      const Summary reference = adjust(stored, {}, options);
      EXPECT_EQ(summary.jacobian_storage, "none");
      ASSERT_EQ(summary.iterations.size(), reference.iterations.size());
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_NEAR(summary.iterations[k].cost, reference.iterations[k].cost,
                    1e-9 * reference.iterations[k].cost);
      }
      EXPECT_NEAR(summary.final_cost, reference.final_cost, 1e-9 * reference.final_cost);
    }
  }
}

LmSolve solved(int iterations) {
  LmSolve step;
  step.solved = true;
  step.iterations = iterations;
  return step;
}

LmTrial trial(double cost, double model_decrease) {
  LmTrial result;
  result.cost = cost;
  result.model_decrease = model_decrease;
  return result;
}

TEST(FloatJacobian, GivesWayWhenStepsSuffer) {
  const auto table = [] { return JacobianTable(JacobianStorage::FLOAT, false, 3); };
  JacobianTable unsolved = table();
  unsolved.observe(LmSolve{});
  EXPECT_TRUE(unsolved.wants_double());
  unsolved.promote();
  EXPECT_FALSE(unsolved.is_rounded());
  EXPECT_NE(unsolved.view().exact, nullptr);
  EXPECT_EQ(unsolved.view().rounded, nullptr);
  EXPECT_EQ(unsolved.description(), "float, then double: a system had no solution");

  JacobianTable slow = table();
  slow.observe(solved(201));
  slow.observe(solved(200));
  EXPECT_FALSE(slow.wants_double());
  slow.observe(solved(201));
  EXPECT_TRUE(slow.wants_double());

  JacobianTable uphill = table();
  uphill.observe(trial(std::numeric_limits<double>::infinity(), -1.0), 10.0, 1e-4);
  EXPECT_FALSE(uphill.wants_double());
  uphill.observe(trial(9.0, 0.0), 10.0, 1e-4);
  EXPECT_TRUE(uphill.wants_double());

  JacobianTable poor = table();
  poor.observe(trial(9.8, 1.0), 10.0, 1e-9);  // much damped: the problem is not linear, no more
  poor.observe(trial(9.8, 1.0), 10.0, 1e-11);
  poor.observe(trial(9.7, 1.0), 10.0, 1e-11);
  EXPECT_FALSE(poor.wants_double());
  poor.observe(trial(9.8, 1.0), 10.0, 1e-11);
  EXPECT_TRUE(poor.wants_double());

  JacobianTable interrupted = table();
  LmSolve stopped;
  stopped.interrupted = true;
  interrupted.observe(stopped);
  EXPECT_FALSE(interrupted.wants_double());
}

TEST(FloatJacobian, LinearizesAgainInDoubleAfterASystemWithoutSolution) {
  const BalProblem problem = test::small_problem();
  Linearized rounded(problem, JacobianStorage::FLOAT);
  Linearized exact(problem, JacobianStorage::DOUBLE);
  rounded.native.solve(-1.0);  // negative damping: not positive definite
  EXPECT_EQ(rounded.native.jacobian_storage(), "float, then double: a system had no solution");
  EXPECT_EQ(rounded.schur(1e-4), exact.schur(1e-4));
}

}  // namespace
}  // namespace raylign::native
