// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>

#include "bundle/native_solvers.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/synthetic/bal.h"
#include "support/small_problem.h"

namespace raylign {
namespace {

BalProblem scene(SyntheticBalKind kind, int num_cameras, int points_per_camera) {
  SyntheticBalOptions options;
  options.kind = kind;
  options.num_cameras = num_cameras;
  options.num_points = points_per_camera * num_cameras;
  options.seed = 5;
  return synthetic_bal(options).problem;
}

class SolverMatrix : public testing::TestWithParam<test::NativeSolver> {
 protected:
  BundleOptions options_ = GetParam().options();
};

TEST_P(SolverMatrix, ReachesTheSameCost) {
  options_.lm.max_num_iterations = 200;
  options_.lm.function_tolerance = 1e-12;
  BundleConfig config;
  config.gauge = Gauge::FIRST_CAMERA;
  config.constant_points = {7};
  for (const BalProblem& problem :
       {test::small_problem(6, 60), scene(SyntheticBalKind::ORBIT, 16, 40),
        scene(SyntheticBalKind::ORBIT, 40, 30)}) {
    BundleOptions reference = options_;
    reference.linear_solver = {};
    reference.linear_solver.type = LinearSolverType::DENSE_SCHUR;
    BalProblem a = problem;
    BalProblem b = problem;
    const Summary expected = adjust(a, config, reference);
    const Summary summary = adjust(b, config, options_);
    EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-6 * expected.final_cost);
    if (GetParam().type != LinearSolverType::AUTO) {
      EXPECT_EQ(summary.linear_solver, GetParam().type);
      EXPECT_EQ(summary.linear_solver_reason, "requested");
    } else {
      EXPECT_NE(summary.linear_solver, LinearSolverType::AUTO);
      EXPECT_EQ(summary.linear_solver_reason.find("auto: "), 0u);
    }
    int most = 0;
    for (const IterationSummary& row : summary.iterations) {
      most = std::max(most, row.linear_solver_iterations);
    }
    EXPECT_EQ(most > 1, GetParam().is_iterative());
  }
}

// Five runs on each number of threads: parameters, and every number of every row but the times.
TEST_P(SolverMatrix, SameBitsForAnyNumberOfThreadsAndOnEveryRun) {
  const BalProblem problem = scene(SyntheticBalKind::STREET, 40, 60);  // several chunks
  options_.lm.max_num_iterations = 3;
  BalProblem reference = problem;
  const Summary expected = adjust(reference, {}, options_);
  EXPECT_FALSE(reference == problem);
  ASSERT_EQ(expected.iterations.size(), 4u);
  for (int run = 0; run < 15; ++run) {
    options_.lm.num_threads = std::array{1, 2, 4}[run % 3];
    BalProblem refined = problem;
    const Summary summary = adjust(refined, {}, options_);
    EXPECT_TRUE(refined == reference) << options_.lm.num_threads << " threads, run " << run;
    ASSERT_EQ(summary.iterations.size(), expected.iterations.size());
    for (std::size_t k = 0; k < summary.iterations.size(); ++k) {
      const IterationSummary& a = summary.iterations[k];
      const IterationSummary& b = expected.iterations[k];
      EXPECT_EQ(a.cost, b.cost);
      EXPECT_EQ(a.gradient_max_norm, b.gradient_max_norm);
      EXPECT_EQ(a.step_norm, b.step_norm);
      EXPECT_EQ(a.gain_ratio, b.gain_ratio);
      EXPECT_EQ(a.linear_solver_iterations, b.linear_solver_iterations);
    }
  }
}

TEST_P(SolverMatrix, StopsInsideALinearSolve) {
  if (!GetParam().is_iterative()) GTEST_SKIP() << "one step";
  BalProblem problem = scene(SyntheticBalKind::STREET, 24, 40);
  int asked = 0;
  const Summary summary = adjust(problem, {}, options_, nullptr, [&] { return ++asked > 4; });
  EXPECT_EQ(asked, 5);
  EXPECT_EQ(summary.termination, Termination::USER_STOPPED);
  EXPECT_TRUE(summary.is_usable());
  EXPECT_LE(summary.final_cost, summary.initial_cost);
  const IterationSummary& last = summary.iterations.back();
  EXPECT_FALSE(last.step_is_accepted);
  EXPECT_EQ(last.cost, summary.final_cost);
}

INSTANTIATE_TEST_SUITE_P(Solvers,
                         SolverMatrix,
                         testing::ValuesIn(test::kNativeSolvers),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace raylign
