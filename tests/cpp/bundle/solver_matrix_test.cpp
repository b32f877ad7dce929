// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

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

struct Solver {
  const char* name;
  LinearSolverType type;
  Preconditioner preconditioner = Preconditioner::SCHUR_JACOBI;
  bool explicit_schur = false;
};

class SolverMatrix : public testing::TestWithParam<Solver> {
 protected:
  void SetUp() override {
    options_.backend = Backend::NATIVE;
    options_.linear_solver.type = GetParam().type;
    options_.linear_solver.preconditioner = GetParam().preconditioner;
    options_.linear_solver.explicit_schur = GetParam().explicit_schur;
  }
  bool is_iterative() const { return GetParam().type == LinearSolverType::ITERATIVE_SCHUR; }

  BundleOptions options_;
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
    EXPECT_EQ(most > 1, is_iterative());
  }
}

TEST_P(SolverMatrix, SameBitsForAnyNumberOfThreadsAndOnEveryRun) {
  const BalProblem problem = scene(SyntheticBalKind::STREET, 100, 60);  // several chunks
  options_.lm.max_num_iterations = 4;
  BalProblem reference = problem;
  const Summary expected = adjust(reference, {}, options_);
  EXPECT_FALSE(reference == problem);
  for (const int num_threads : {1, 2, 4, 4}) {
    options_.lm.num_threads = num_threads;
    BalProblem refined = problem;
    EXPECT_EQ(adjust(refined, {}, options_).final_cost, expected.final_cost);
    EXPECT_TRUE(refined == reference) << num_threads << " threads";
  }
}

TEST_P(SolverMatrix, StopsInsideALinearSolve) {
  if (!is_iterative()) GTEST_SKIP() << "one step";
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
                         testing::Values(Solver{"auto", LinearSolverType::AUTO},
                                         Solver{"dense", LinearSolverType::DENSE_SCHUR},
                                         Solver{"sparse", LinearSolverType::SPARSE_SCHUR},
                                         Solver{"jacobi", LinearSolverType::ITERATIVE_SCHUR,
                                                Preconditioner::JACOBI},
                                         Solver{"matrix_free", LinearSolverType::ITERATIVE_SCHUR},
                                         Solver{"explicit", LinearSolverType::ITERATIVE_SCHUR,
                                                Preconditioner::SCHUR_JACOBI, true},
                                         Solver{"two_level", LinearSolverType::ITERATIVE_SCHUR,
                                                Preconditioner::TWO_LEVEL, true},
                                         Solver{"stale_factor", LinearSolverType::ITERATIVE_SCHUR,
                                                Preconditioner::STALE_FACTOR, true}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace raylign
