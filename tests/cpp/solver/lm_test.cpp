// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/lm.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <stdexcept>

namespace raylign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Any small dense problem r(x), J(x), solved by normal equations: the loop's contract, nothing
// else.
class DenseProblem {
 public:
  std::function<VectorXd(const VectorXd&)> residual;
  std::function<MatrixXd(const VectorXd&)> jacobian;
  VectorXd x;
  LmOptions options;
  std::function<bool(int)> solvable = [](int) { return true; };  // of the solve's number
  int num_linearizations = 0;
  int num_solves = 0;
  double loosen = 0.0;  // > 0: what is left of a step that need not be exact
  int num_tight = 0;

  LmState linearize() {
    ++num_linearizations;
    r_ = residual(x);
    J_ = jacobian(x);
    if (scale_.size() == 0) {
      scale_ = J_.colwise().squaredNorm().transpose().unaryExpr(
          [&](double h) { return lm_column_scale(h, options); });
    }
    return {0.5 * r_.squaredNorm(), (J_.transpose() * r_).cwiseAbs().maxCoeff()};
  }

  LmSolve solve(double lambda, bool tight) {
    num_tight += tight ? 1 : 0;
    if (!solvable(num_solves++)) return {false};
    MatrixXd H = J_.transpose() * J_;
    for (int k = 0; k < H.rows(); ++k) H(k, k) += lambda * lm_damping(H(k, k), scale_[k], options);
    step_ = -H.ldlt().solve(J_.transpose() * r_);
    if (!tight && loosen > 0.0) {
      step_ *= loosen;
      return {true, 1, false, true};
    }
    return {step_.allFinite()};
  }

  LmTrial try_step() {
    trial_ = x + step_;
    const VectorXd J_step = J_ * step_;
    return {0.5 * residual(trial_).squaredNorm(), -J_step.dot(r_ + 0.5 * J_step), step_.norm(),
            x.norm()};
  }

  void accept() { x = trial_; }

 private:
  VectorXd r_, step_, trial_, scale_;
  MatrixXd J_;
};

DenseProblem rosenbrock() {
  DenseProblem problem;
  problem.residual = [](const VectorXd& x) {
    return VectorXd(Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]));
  };
  problem.jacobian = [](const VectorXd& x) {
    MatrixXd J(2, 2);
    J << -20.0 * x[0], 10.0, -1.0, 0.0;
    return J;
  };
  problem.x = Eigen::Vector2d(-1.2, 1.0);
  return problem;
}

// Powell's singular function: J loses rank at the solution 0.
DenseProblem powell() {
  DenseProblem problem;
  problem.residual = [](const VectorXd& x) {
    const double a = x[1] - 2.0 * x[2];
    const double b = x[0] - x[3];
    return VectorXd(Eigen::Vector4d(x[0] + 10.0 * x[1], std::sqrt(5.0) * (x[2] - x[3]), a * a,
                                    std::sqrt(10.0) * b * b));
  };
  problem.jacobian = [](const VectorXd& x) {
    const double a = 2.0 * (x[1] - 2.0 * x[2]);
    const double b = 2.0 * std::sqrt(10.0) * (x[0] - x[3]);
    MatrixXd J(4, 4);
    J << 1.0, 10.0, 0.0, 0.0,                       //
        0.0, 0.0, std::sqrt(5.0), -std::sqrt(5.0),  //
        0.0, a, -2.0 * a, 0.0,                      //
        b, 0.0, 0.0, -b;
    return J;
  };
  problem.x = Eigen::Vector4d(3.0, -1.0, 0.0, 1.0);
  return problem;
}

// r(x) = x, but no cost beyond |x| < 1: the first full steps of a bad start leave the domain.
DenseProblem square_root_domain() {
  DenseProblem problem;
  problem.residual = [](const VectorXd& x) {
    return VectorXd(Eigen::Matrix<double, 1, 1>(std::log(x[0])));  // NaN for x < 0
  };
  problem.jacobian = [](const VectorXd& x) {
    return MatrixXd(Eigen::Matrix<double, 1, 1>(1.0 / x[0]));
  };
  problem.x = Eigen::Matrix<double, 1, 1>(20.0);  // Gauss-Newton goes to 20 − 20 log 20 < 0
  return problem;
}

Summary run(DenseProblem& problem,
            const IterationCallback& callback = nullptr,
            LambdaRule rule = LambdaRule::CERES) {
  const Stopwatch clock;
  return minimize(problem, problem.options, callback, clock, 7, rule);
}

TEST(Lm, SolvesRosenbrock) {
  DenseProblem problem = rosenbrock();
  problem.options.function_tolerance = 0.0;
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE) << summary.message;
  EXPECT_NEAR(problem.x[0], 1.0, 1e-9);
  EXPECT_NEAR(problem.x[1], 1.0, 1e-9);
  EXPECT_GT(summary.num_rejected, 0);  // the valley bends
}

TEST(Lm, SolvesPowellToItsSingularPoint) {
  DenseProblem problem = powell();
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE) << summary.message;
  EXPECT_LT(problem.x.norm(), 1e-2);
  EXPECT_LT(summary.final_cost, 1e-9);
}

TEST(Lm, RowsTellTheSameStoryAsTheSummary) {
  DenseProblem problem = rosenbrock();
  const Summary summary = run(problem);
  const auto& rows = summary.iterations;
  EXPECT_EQ(rows.front().cost, summary.initial_cost);
  EXPECT_EQ(rows.front().lambda, 1e-4);
  EXPECT_FALSE(rows.front().step_is_valid);
  EXPECT_EQ(rows.front().linear_solver_iterations, 0);
  EXPECT_EQ(rows.back().cost, summary.final_cost);
  EXPECT_NEAR(summary.final_cost, 0.5 * problem.residual(problem.x).squaredNorm(), 1e-15);
  int accepted = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].iteration, static_cast<int>(i));
    EXPECT_EQ(rows[i].num_residual_blocks, 7);
    EXPECT_NEAR(rows[i - 1].cost - rows[i].cost, rows[i].cost_change, 1e-12);
    EXPECT_EQ(rows[i].step_is_accepted, rows[i].cost_change > 0.0);
    accepted += rows[i].step_is_accepted ? 1 : 0;
  }
  EXPECT_EQ(accepted, summary.num_accepted);
  EXPECT_EQ(problem.num_linearizations, 1 + accepted - 1);  // the last state needs no derivatives
}

TEST(Lm, LambdaFollowsNielsensRule) {
  DenseProblem problem = rosenbrock();
  double nu = 2.0;
  const Summary summary = run(problem);
  for (std::size_t i = 1; i + 1 < summary.iterations.size(); ++i) {
    const IterationSummary& row = summary.iterations[i];
    const double factor = row.lambda / summary.iterations[i - 1].lambda;
    if (row.step_is_accepted) {
      const double q = 2.0 * row.gain_ratio - 1.0;
      EXPECT_NEAR(factor, std::max(1.0 / 3.0, 1.0 - q * q * q), 1e-12);
      nu = 2.0;
    } else {
      EXPECT_NEAR(factor, nu, 1e-12);
      nu *= 2.0;
    }
  }
}

TEST(Lm, TheFastRuleTrustsAModelThatKeptItsPromise) {
  DenseProblem problem = powell();
  const Summary summary = run(problem, nullptr, LambdaRule::FAST);
  int good = 0;
  int fair = 0;
  for (std::size_t i = 1; i + 1 < summary.iterations.size(); ++i) {
    const IterationSummary& row = summary.iterations[i];
    ASSERT_TRUE(row.step_is_accepted);
    const double q = 2.0 * row.gain_ratio - 1.0;
    const bool is_good = row.gain_ratio > 0.8;
    const double factor = is_good ? 0.1 : std::max(1.0 / 3.0, 1.0 - q * q * q);
    const double before = summary.iterations[i - 1].lambda;
    EXPECT_DOUBLE_EQ(row.lambda, std::max(problem.options.min_lambda, before * factor));
    ++(is_good ? good : fair);
  }
  EXPECT_GT(good, 0);
  DenseProblem bent = rosenbrock();
  for (const IterationSummary& row : run(bent, nullptr, LambdaRule::FAST).iterations) {
    fair += row.step_is_accepted && row.gain_ratio <= 0.8 ? 1 : 0;
  }
  EXPECT_GT(fair, 0);  // and Nielsen's rule where it did not
}

// The first step lands at the same cost on the other side of a valley: Ceres' rule calls that
// converged, though the model had promised a lot.
TEST(Lm, TheFastRuleTakesNoRejectedStepForConvergence) {
  DenseProblem problem;  // r = x² − 1 from where Newton's step ends at −r: 5 x⁴ − 6 x² + 1 = 0
  problem.residual = [](const VectorXd& x) { return VectorXd(x.array().square() - 1.0); };
  problem.jacobian = [](const VectorXd& x) { return MatrixXd((2.0 * x).asDiagonal()); };
  problem.x = VectorXd::Constant(1, std::sqrt(0.2));
  problem.options.initial_lambda = 1e-12;
  problem.options.function_tolerance = 1e-6;
  DenseProblem other = problem;
  const Summary ceres = run(problem, nullptr, LambdaRule::CERES);
  EXPECT_EQ(ceres.iterations.size(), 2u);
  EXPECT_GT(ceres.final_cost, 0.1);
  const Summary fast = run(other, nullptr, LambdaRule::FAST);
  EXPECT_FALSE(fast.iterations[1].step_is_accepted);
  EXPECT_LT(fast.final_cost, 1e-9);
}

TEST(Lm, TheG2oRuleLowersLambdaAfterEveryAcceptedStep) {
  DenseProblem problem = rosenbrock();
  const Summary summary = run(problem, nullptr, LambdaRule::G2O);
  int weak = 0;
  for (std::size_t i = 1; i + 1 < summary.iterations.size(); ++i) {
    const IterationSummary& row = summary.iterations[i];
    if (!row.step_is_accepted) continue;
    const double q = 2.0 * row.gain_ratio - 1.0;
    const double factor = std::clamp(1.0 - q * q * q, 1.0 / 3.0, 2.0 / 3.0);
    const double before = summary.iterations[i - 1].lambda;
    EXPECT_DOUBLE_EQ(row.lambda, std::max(problem.options.min_lambda, before * factor));
    weak += 1.0 - q * q * q > 2.0 / 3.0 ? 1 : 0;
  }
  EXPECT_GT(weak, 0);  // else the bound was never in the way
}

TEST(Lm, StepsOutsideTheDomainAreInvalidAndRaiseLambda) {
  DenseProblem problem = square_root_domain();
  problem.options.max_num_consecutive_invalid_steps = 20;
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE) << summary.message;
  EXPECT_NEAR(problem.x[0], 1.0, 1e-6);
  const IterationSummary& first = summary.iterations[1];
  EXPECT_FALSE(first.step_is_valid);
  EXPECT_FALSE(first.step_is_accepted);
  EXPECT_EQ(first.cost, summary.initial_cost);
  EXPECT_EQ(first.step_norm, 0.0);
  EXPECT_DOUBLE_EQ(first.lambda, 2e-4);
}

TEST(Lm, FiveInvalidStepsInARowAreAFailure) {
  DenseProblem problem = rosenbrock();
  problem.solvable = [](int k) { return k < 2; };
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::FAILURE);
  EXPECT_NE(summary.message.find("5 consecutive"), std::string::npos) << summary.message;
  EXPECT_EQ(problem.num_solves, 2 + 5);
  EXPECT_EQ(summary.iterations.size(), 1u + 2u + 5u);
}

TEST(Lm, AValidStepResetsTheCountOfInvalidOnes) {
  DenseProblem problem = rosenbrock();
  problem.options.max_num_iterations = 30;
  problem.options.max_num_consecutive_invalid_steps = 2;
  problem.solvable = [](int k) { return k % 2 == 1; };
  EXPECT_NE(run(problem).termination, Termination::FAILURE);
}

TEST(Lm, AStartWithoutCostIsAFailure) {
  DenseProblem problem = square_root_domain();
  problem.x[0] = -1.0;
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::FAILURE);
  EXPECT_EQ(problem.num_solves, 0);
  EXPECT_EQ(summary.iterations.size(), 1u);
}

TEST(Lm, ZeroIterationsOnlyEvaluate) {
  DenseProblem problem = rosenbrock();
  problem.options.max_num_iterations = 0;
  const VectorXd before = problem.x;
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::MAX_ITERATIONS);
  EXPECT_EQ(summary.iterations.size(), 1u);
  EXPECT_EQ(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(problem.x, before);
  EXPECT_EQ(problem.num_solves, 0);
}

TEST(Lm, TimeLimitStops) {
  DenseProblem problem = rosenbrock();
  problem.options.max_solver_time_s = 1e-12;
  EXPECT_EQ(run(problem).termination, Termination::TIME_LIMIT);
}

TEST(Lm, AFlatStartConverges) {
  DenseProblem problem = rosenbrock();
  problem.x = Eigen::Vector2d(1.0, 1.0);
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE);
  EXPECT_NE(summary.message.find("Gradient"), std::string::npos) << summary.message;
  EXPECT_EQ(problem.num_solves, 0);
}

TEST(Lm, ALargeLambdaGivesUp) {
  DenseProblem problem = rosenbrock();
  problem.options.max_lambda = 1e-3;
  problem.options.max_num_consecutive_invalid_steps = 100;
  problem.solvable = [](int) { return false; };
  const Summary summary = run(problem);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE);
  EXPECT_NE(summary.message.find("max_lambda"), std::string::npos) << summary.message;
}

TEST(Lm, CallbackStopsWithTheBestState) {
  DenseProblem problem = rosenbrock();
  const Summary summary = run(problem, [](const IterationSummary& row) {
    return row.iteration < 4 ? CallbackAction::CONTINUE : CallbackAction::STOP;
  });
  EXPECT_EQ(summary.termination, Termination::USER_STOPPED);
  EXPECT_EQ(summary.iterations.size(), 5u);
  EXPECT_DOUBLE_EQ(summary.final_cost, 0.5 * problem.residual(problem.x).squaredNorm());
}

TEST(Lm, AnExceptionOfTheCallbackPassesThrough) {
  DenseProblem problem = rosenbrock();
  const auto callback = [](const IterationSummary& row) -> CallbackAction {
    if (row.iteration == 2) throw std::logic_error("mine");
    return CallbackAction::CONTINUE;
  };
  EXPECT_THROW(run(problem, callback), std::logic_error);
}

TEST(Lm, DampingIsCeresClampOnScaledColumns) {
  LmOptions options;
  const double h = 4e4;
  const double s = lm_column_scale(h, options);
  EXPECT_DOUBLE_EQ(s, 1.0 / 201.0);
  EXPECT_DOUBLE_EQ(lm_damping(h, s, options), h);  // inside the clamp: h itself
  EXPECT_DOUBLE_EQ(lm_damping(0.0, 1.0, options), 1e-6);
  EXPECT_DOUBLE_EQ(lm_damping(0.0, 0.5, options), 4e-6);
  options.jacobi_scaling = false;
  EXPECT_EQ(lm_column_scale(h, options), 1.0);
}

// A step that an iterative solver cut short is small for that reason alone.
TEST(LmLoop, AnInexactSmallStepIsNoConvergence) {
  DenseProblem problem = rosenbrock();
  problem.loosen = 1e-12;
  const Summary summary = minimize(problem, problem.options, nullptr, Stopwatch(), 2);
  EXPECT_EQ(summary.termination, Termination::CONVERGENCE);
  EXPECT_GT(problem.num_tight, 2);
  EXPECT_LT(summary.final_cost, 1e-12);
}

TEST(LmLoop, AnInterruptedSolveEndsWithTheBestState) {
  DenseProblem problem = rosenbrock();
  struct Interrupted {
    DenseProblem& inner;
    LmState linearize() { return inner.linearize(); }
    LmSolve solve(double lambda, bool tight) {
      if (inner.num_solves == 8) return {false, 7, true};
      return inner.solve(lambda, tight);
    }
    LmTrial try_step() { return inner.try_step(); }
    void accept() { inner.accept(); }
  } interrupted{problem};
  LmOptions options;
  const Summary summary = minimize(interrupted, options, nullptr, Stopwatch(), 2);
  EXPECT_EQ(summary.termination, Termination::USER_STOPPED);
  EXPECT_EQ(summary.iterations.size(), 10u);
  EXPECT_EQ(summary.iterations.back().linear_solver_iterations, 7);
  EXPECT_EQ(summary.iterations.back().cost, summary.final_cost);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

}  // namespace
}  // namespace raylign
