// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>

#include "bundle/reference.h"
#include "raylign/base/error.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/io/bal.h"
#include "raylign/parametrization/constants.h"
#include "support/eigen_matchers.h"
#include "support/small_problem.h"

namespace raylign {
namespace {

using native::ReprojectionProblem;
using test::is_relatively_near;

struct Setting {
  const char* name;
  PoseParametrization pose;
  Gauge gauge = Gauge::FREE;
  LossType loss = LossType::TRIVIAL;
  bool held_points = false;
  PointParametrization point = PointParametrization::XYZ;
};

BundleOptions options_of(const Setting& setting) {
  BundleOptions options;
  options.pose_parametrization = setting.pose;
  options.point_parametrization = setting.point;
  options.loss = {setting.loss, 1.5};
  options.linear_solver.type = LinearSolverType::DENSE_SCHUR;
  options.parity = true;
  return options;
}

BundleConfig config_of(const Setting& setting) {
  BundleConfig config;
  config.gauge = setting.gauge;
  if (setting.held_points) {
    config.constant_points = {2, 11};
    config.constant_coordinates = {{ParameterKind::POINT, 5, "y"},
                                   {ParameterKind::POSE, 1, "tx"},
                                   {ParameterKind::POSE, 2, "rotation"},
                                   {ParameterKind::INTRINSICS, 3, "k2"}};
    if (setting.point != PointParametrization::XYZ) {  // a sphere has no single coordinates
      config.constant_coordinates.erase(config.constant_coordinates.begin());
    }
    config.constant_cameras = {4};
  }
  return config;
}

class Schur : public testing::TestWithParam<Setting> {
 protected:
  const BalProblem problem_ = test::small_problem();
  const BundleOptions options_ = options_of(GetParam());
  const BundleConfig config_ = config_of(GetParam());
  const test::DenseSystem dense_{problem_, config_, options_};
  ReprojectionProblem native_{problem_, resolve_constants(problem_, config_), options_};
};

TEST_P(Schur, LinearizationHasTheCostAndGradientOfTheCeresPath) {
  const LmState state = native_.linearize();
  const Eigen::VectorXd gradient = dense_.J.transpose() * dense_.r;
  EXPECT_EQ(native_.num_effective_parameters(), dense_.J.cols());
  EXPECT_NEAR(state.cost, linearize(problem_, config_, options_).cost, 1e-12 * state.cost);
  EXPECT_NEAR(state.gradient_max_norm, gradient.cwiseAbs().maxCoeff(),
              1e-10 * state.gradient_max_norm);
}

TEST_P(Schur, SystemEqualsDenseElimination) {
  native_.linearize();
  const native::CameraBlocks& cameras = native_.cameras();
  const native::SolverContext context{native_.layout(), cameras, native_.pool()};
  native::SchurSystem system(
      context, native::SchurPattern(context.layout, native::moving_cameras(context.cameras)));
  for (const double lambda : {1e-4, 1.0}) {
    system.form(native_.damped(lambda));
    const Eigen::Index n = cameras.num_columns();
    const Eigen::Index m = dense_.J.cols() - n;
    const Eigen::VectorXd g = dense_.J.transpose() * dense_.r;
    Eigen::MatrixXd H = dense_.J.transpose() * dense_.J;
    H.diagonal() += dense_.damping(lambda, options_.lm);
    const auto H_ll = H.bottomRightCorner(m, m).llt();
    const Eigen::MatrixXd S =
        H.topLeftCorner(n, n) -
        H.topRightCorner(n, m) * H_ll.solve(Eigen::MatrixXd(H.bottomLeftCorner(m, n)));
    const Eigen::VectorXd b =
        -g.head(n) + H.topRightCorner(n, m) * H_ll.solve(Eigen::VectorXd(g.tail(m)));
    const Eigen::MatrixXd ours = test::dense_schur(system);
    Eigen::VectorXd rhs(n);
    native::pack(cameras, system.rhs().data(), rhs.data());
    // columns have very different units: compare correlations, not numbers
    const Eigen::VectorXd scale = S.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_LT((scale.asDiagonal() * (ours - S) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_TRUE(is_relatively_near(scale.asDiagonal() * rhs, scale.asDiagonal() * b, 1e-10));
  }
}

TEST_P(Schur, StepEqualsDenseQrOfTheAugmentedSystem) {
  native_.linearize();
  double trial_cost = -1.0;
  for (const double lambda : {1e-4, 1e-2, 1.0}) {
    ASSERT_TRUE(native_.solve(lambda).solved);
    const LmTrial trial = native_.try_step();
    const Eigen::VectorXd step = dense_.step(lambda, options_.lm);
    const Eigen::Index n = native_.cameras().num_columns();
    const Eigen::VectorXd units = dense_.J.colwise().norm().transpose();
    EXPECT_TRUE(
        is_relatively_near(units.head(n).asDiagonal() *
                               Eigen::Map<const Eigen::VectorXd>(native_.camera_step().data(), n),
                           units.head(n).asDiagonal() * step.head(n), 1e-9));
    EXPECT_NEAR(trial.step_norm, step.norm(), 1e-9 * step.norm());
    const Eigen::VectorXd J_step = dense_.J * step;
    const double decrease = -J_step.dot(dense_.r + 0.5 * J_step);
    EXPECT_NEAR(trial.model_decrease, decrease, 1e-9 * decrease);
    trial_cost = trial.cost;
  }
  native_.accept();
  EXPECT_NEAR(native_.linearize().cost, trial_cost, 1e-12 * trial_cost);
}

INSTANTIATE_TEST_SUITE_P(
    Settings,
    Schur,
    testing::Values(Setting{"se3", PoseParametrization::SE3},
                    Setting{"quaternion", PoseParametrization::QUATERNION},
                    Setting{"angle_axis", PoseParametrization::ANGLE_AXIS},
                    Setting{"two_cameras", PoseParametrization::SE3, Gauge::TWO_CAMERAS},
                    Setting{"cauchy", PoseParametrization::SE3, Gauge::FIRST_CAMERA,
                            LossType::CAUCHY},
                    Setting{"held", PoseParametrization::SE3, Gauge::FREE, LossType::HUBER, true},
                    Setting{"held_angle_axis", PoseParametrization::ANGLE_AXIS, Gauge::FIRST_CAMERA,
                            LossType::TRIVIAL, true},
                    Setting{"homogeneous", PoseParametrization::SE3, Gauge::FREE, LossType::TRIVIAL,
                            false, PointParametrization::HOMOGENEOUS},
                    Setting{"homogeneous_angle_axis", PoseParametrization::ANGLE_AXIS, Gauge::FREE,
                            LossType::CAUCHY, false, PointParametrization::HOMOGENEOUS},
                    Setting{"homogeneous_held", PoseParametrization::QUATERNION, Gauge::TWO_CAMERAS,
                            LossType::HUBER, true, PointParametrization::HOMOGENEOUS}),
    [](const auto& instance) { return instance.param.name; });

// --- the path of Ceres, cost by cost -------------------------------------------------------------

void expect_same_path(const BalProblem& problem,
                      const BundleConfig& config,
                      BundleOptions options,
                      int max_num_iterations = 30) {
  options.lm.max_num_iterations = max_num_iterations;
  options.lm.function_tolerance = 1e-12;
  BalProblem ours = problem;
  BalProblem theirs = problem;
  options.backend = Backend::NATIVE;
  const Summary native = adjust(ours, config, options);
  options.backend = Backend::CERES;
  const Summary ceres = adjust(theirs, config, options);
  EXPECT_EQ(native.num_effective_parameters, ceres.num_effective_parameters);
  EXPECT_EQ(native.num_residuals, ceres.num_residuals);
  const std::size_t rows = std::min(native.iterations.size(), ceres.iterations.size());
  ASSERT_GE(rows, 5u);
  for (std::size_t i = 0; i < std::min<std::size_t>(rows, 11); ++i) {
    const IterationSummary& a = native.iterations[i];
    const IterationSummary& b = ceres.iterations[i];
    EXPECT_NEAR(a.cost, b.cost, 1e-8 * b.cost) << "iteration " << i;
    EXPECT_NEAR(a.lambda, b.lambda, 1e-5 * b.lambda) << "iteration " << i;
    EXPECT_EQ(a.step_is_accepted, b.step_is_accepted) << "iteration " << i;
  }
  EXPECT_NEAR(native.final_cost, ceres.final_cost, 1e-9 * ceres.final_cost);
}

TEST_P(Schur, WalksThePathOfCeres) { expect_same_path(problem_, config_, options_); }

// The scene mirrored: more steps are refused on the way than are taken.
TEST(Native, WalksThePathOfCeresThroughRejectedSteps) {
  BalProblem problem = test::small_problem();
  problem.points *= -1.0;
  BundleConfig config;
  config.gauge = Gauge::TWO_CAMERAS;
  BundleOptions options = options_of({"", PoseParametrization::SE3});
  expect_same_path(problem, config, options, 10);
  options.backend = Backend::NATIVE;
  options.lm.max_num_iterations = 10;
  EXPECT_GE(adjust(problem, config, options).num_rejected, 4);
}

// GTSAM's dubrovnik-3-7: 38 residuals, 48 parameters, rejected steps.
TEST(Native, WalksThePathOfCeresOnDubrovnik) {
  const std::string file = std::string(RAYLIGN_SHARED_DATA_DIR) + "/bal/problem-3-7-pre.txt";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file;
  for (const auto pose : {PoseParametrization::ANGLE_AXIS, PoseParametrization::SE3}) {
    expect_same_path(read_bal(file), {}, options_of({"", pose}), 10);
  }
}

TEST(Native, WalksThePathOfCeresOnLadybug) {
  const std::string file = std::string(RAYLIGN_SHARED_DATA_DIR) + "/bal/problem-49-7776-pre.txt";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file;
  BundleOptions options = options_of({"", PoseParametrization::ANGLE_AXIS});
  const BalProblem problem = read_bal(file);
  options.lm.max_num_iterations = 10;
  BalProblem ours = problem;
  BalProblem theirs = problem;
  const Summary ceres = adjust(theirs, {}, options);
  options.backend = Backend::NATIVE;
  const Summary native = adjust(ours, {}, options);
  ASSERT_EQ(native.iterations.size(), 11u);
  for (std::size_t i = 0; i < 11; ++i) {
    const double cost = ceres.iterations[i].cost;
    EXPECT_NEAR(native.iterations[i].cost, cost, 1e-8 * cost) << "iteration " << i;
  }
}

TEST(Native, RejectedStepsLeaveTheStateAndTheCostAlone) {
  BalProblem problem = test::small_problem();
  problem.points *= 3.0;  // a start far outside the quadratic region
  BundleOptions options = options_of({"", PoseParametrization::SE3});
  options.lm.initial_lambda = 1e-12;
  options.backend = Backend::NATIVE;
  BalProblem ours = problem;
  const Summary native = adjust(ours, {}, options);
  EXPECT_GT(native.num_rejected, 0);
  for (std::size_t i = 1; i < native.iterations.size(); ++i) {
    if (native.iterations[i].step_is_accepted) continue;
    EXPECT_EQ(native.iterations[i].cost, native.iterations[i - 1].cost);
  }
}

// --- same bits -----------------------------------------------------------------------------------

TEST(Native, SameBitsForAnyNumberOfThreadsAndOnEveryRun) {
  const BalProblem problem = test::small_problem(12, 1200);  // several chunks
  BundleOptions options = options_of({"", PoseParametrization::SE3});
  options.backend = Backend::NATIVE;
  options.loss = {LossType::HUBER, 1.0};
  options.lm.max_num_iterations = 6;
  BalProblem reference = problem;
  const Summary expected = adjust(reference, {}, options);
  EXPECT_TRUE(expected.deterministic);
  EXPECT_FALSE(reference == problem);
  for (const int num_threads : {1, 2, 3, 4, 4, 1}) {
    options.lm.num_threads = num_threads;
    BalProblem refined = problem;
    const Summary summary = adjust(refined, {}, options);
    EXPECT_TRUE(refined == reference) << num_threads << " threads";
    EXPECT_EQ(summary.final_cost, expected.final_cost);
    EXPECT_EQ(summary.num_threads, num_threads);
  }
}

// --- invariances ---------------------------------------------------------------------------------

Summary tight_solve(BalProblem& problem, const BundleConfig& config = {}) {
  BundleOptions options;
  options.backend = Backend::NATIVE;
  options.lm.max_num_iterations = 100;
  options.lm.function_tolerance = 1e-15;
  return adjust(problem, config, options);
}

TEST(Native, OrderOfObservationsPointsAndCamerasDoesNotMatter) {
  const BalProblem problem = test::small_problem();
  BalProblem shuffled = problem;
  auto rng = test::make_rng("permutation");
  std::vector<int> observation(problem.num_observations());
  std::vector<int> camera(problem.num_cameras());
  std::vector<int> point(problem.num_points());
  for (auto* order : {&observation, &camera, &point}) {
    std::iota(order->begin(), order->end(), 0);
    std::shuffle(order->begin(), order->end(), rng.engine());
  }
  for (std::int64_t i = 0; i < problem.num_cameras(); ++i) {
    shuffled.cameras.row(camera[i]) = problem.cameras.row(i);
  }
  for (std::int64_t i = 0; i < problem.num_points(); ++i) {
    shuffled.points.row(point[i]) = problem.points.row(i);
  }
  for (std::int64_t i = 0; i < problem.num_observations(); ++i) {
    shuffled.camera_index[observation[i]] = camera[problem.camera_index[i]];
    shuffled.point_index[observation[i]] = point[problem.point_index[i]];
    shuffled.observations.row(observation[i]) = problem.observations.row(i);
  }
  BalProblem a = problem;
  const double cost = tight_solve(a).final_cost;
  EXPECT_NEAR(tight_solve(shuffled).final_cost, cost, 1e-10 * cost);
}

TEST(Native, TheUnitOfPixelsDoesNotMatter) {
  BalProblem problem = test::small_problem();
  BalProblem scaled = problem;
  constexpr double kScale = 0.37;  // no power of two: other digits
  scaled.observations *= kScale;
  scaled.cameras.col(6) *= kScale;
  const double cost = tight_solve(problem).final_cost;
  const double expected = kScale * kScale * cost;
  EXPECT_NEAR(tight_solve(scaled).final_cost, expected, 1e-10 * expected);
}

TEST(Native, AMovedAndScaledWorldHasTheSameMinimum) {
  BalProblem problem = test::small_problem();
  BalProblem moved = problem;
  const Matrix3 R = so3_exp({0.4, -0.8, 1.1});
  const Vector3 offset(3.0, -1.0, 2.0);
  constexpr double kScale = 3.7;  // X′ = s R X + offset
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    moved.points.row(p) = (kScale * R * problem.points.row(p).transpose() + offset).transpose();
  }
  for (std::int64_t c = 0; c < problem.num_cameras(); ++c) {
    const Matrix3 R_c = so3_exp(problem.cameras.row(c).head<3>().transpose()) * R.transpose();
    const Vector3 t = problem.cameras.row(c).segment<3>(3).transpose();
    moved.cameras.row(c).head<3>() = so3_log(R_c).transpose();
    moved.cameras.row(c).segment<3>(3) = (kScale * t - R_c * offset).transpose();
  }
  const double cost = tight_solve(problem).final_cost;
  EXPECT_NEAR(tight_solve(moved).final_cost, cost, 1e-10 * cost);
}

TEST(Native, EveryGaugeReachesTheSameCost) {
  std::vector<double> costs;
  for (const Gauge gauge : {Gauge::FREE, Gauge::FIRST_CAMERA, Gauge::TWO_CAMERAS}) {
    BalProblem problem = test::small_problem();
    BundleConfig config;
    config.gauge = gauge;
    costs.push_back(tight_solve(problem, config).final_cost);
  }
  EXPECT_NEAR(costs[1], costs[0], 1e-10 * costs[0]);
  EXPECT_NEAR(costs[2], costs[0], 1e-10 * costs[0]);
}

// --- what it refuses -----------------------------------------------------------------------------

TEST(Native, RefusesWhatItDoesNotDo) {
  BalProblem problem = test::small_problem();
  BundleOptions options;
  options.backend = Backend::NATIVE;
  options.point_parametrization = PointParametrization::INVERSE_DEPTH;
  EXPECT_THROW(adjust(problem, {}, options), OptionsError);
  options.point_parametrization = PointParametrization::XYZ;
  LinearSolverOptions& solver = options.linear_solver;
  solver.type = LinearSolverType::DENSE_NORMAL_CHOLESKY;
  EXPECT_THROW(adjust(problem, {}, options), OptionsError);
  solver.type = LinearSolverType::ITERATIVE_SCHUR;
  for (const auto kind : {Preconditioner::CLUSTER_JACOBI, Preconditioner::CLUSTER_TRIDIAGONAL,
                          Preconditioner::TWO_LEVEL, Preconditioner::STALE_FACTOR}) {
    solver.preconditioner = kind;  // the last two without explicit_schur
    EXPECT_THROW(adjust(problem, {}, options), OptionsError) << to_string(kind);
  }
}

}  // namespace
}  // namespace raylign
