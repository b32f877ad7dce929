// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Degenerate, deficient and broken problems with every linear solver of the native engine: a finite
// answer that is what it says it is, or a failure that leaves the problem alone.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <numeric>
#include <type_traits>
#include <vector>

#include "bundle/native_solvers.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/scene/bundle_scene.h"
#include "support/small_problem.h"

namespace raylign {
namespace {

constexpr int kCameras = 4;
constexpr int kPoints = 20;

struct Task {
  BalProblem problem = test::small_problem(kCameras, kPoints);
  BundleConfig config;
  int max_num_iterations = 30;
};

struct Awkward {
  const char* name;
  void (*spoil)(Task&);
  bool fails = false;
};

std::vector<std::int32_t> all(int count) {
  std::vector<std::int32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

// The problem with the observations for which keep(camera, point) holds.
template <typename Keep>
void keep_observations(Task& task, const Keep& keep) {
  BalProblem& problem = task.problem;
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < problem.camera_index.size(); ++i) {
    if (!keep(problem.camera_index[i], problem.point_index[i])) continue;
    problem.camera_index[count] = problem.camera_index[i];
    problem.point_index[count] = problem.point_index[i];
    problem.observations.row(count++) = problem.observations.row(i).eval();
  }
  problem.camera_index.conservativeResize(count);
  problem.point_index.conservativeResize(count);
  problem.observations.conservativeResize(count, 2);
}

void observe_twice(Task& task) {
  BalProblem& p = task.problem;
  const auto doubled = [](const auto& rows) {
    std::decay_t<decltype(rows)> twice(2 * rows.rows(), rows.cols());
    twice << rows, rows;
    return twice;
  };
  p.camera_index = doubled(p.camera_index);
  p.point_index = doubled(p.point_index);
  p.observations = doubled(p.observations);
}

void stand_in_one_place(Task& task) {  // no parallax: no depth
  for (Eigen::Index i = 0; i < kCameras; ++i) {
    auto camera = task.problem.cameras.row(i);
    camera.segment<3>(3) << 0.0, 0.0, -6.0;
    camera.head<3>() << 0.01 * static_cast<double>(i), 0.0, 0.0;
  }
  for (Eigen::Index i = 0; i < kCameras; ++i) {  // centre −Rᵀt is the first camera's
    const auto R = [&](Eigen::Index k) {
      return so3_exp(task.problem.cameras.row(k).head<3>().transpose());
    };
    const Vector3 t = R(i) * R(0).transpose() * Vector3(0.0, 0.0, -6.0);
    task.problem.cameras.row(i).segment<3>(3) = t.transpose();
  }
}

const Awkward kAwkward[] = {
    {"no_iterations", [](Task& t) { t.max_num_iterations = 0; }},
    {"no_observations", [](Task& t) { keep_observations(t, [](int, int) { return false; }); }},
    {"one_observation",
     [](Task& t) { keep_observations(t, [](int c, int p) { return c == 1 && p == 3; }); }},
    {"one_camera", [](Task& t) { keep_observations(t, [](int c, int) { return c == 1; }); }},
    {"one_point", [](Task& t) { keep_observations(t, [](int, int p) { return p == 3; }); }},
    {"two_cameras", [](Task& t) { keep_observations(t, [](int c, int) { return c < 2; }); }},
    {"points_seen_once",
     [](Task& t) { keep_observations(t, [](int c, int p) { return p % kCameras == c; }); }},
    {"two_parts",  // that share nothing
     [](Task& t) { keep_observations(t, [](int c, int p) { return (c < 2) == (p < 10); }); }},
    {"unobserved",
     [](Task& t) { keep_observations(t, [](int c, int p) { return c != 2 && p % 5 != 0; }); }},
    {"seen_twice", observe_twice},
    {"all_held",
     [](Task& t) {
       t.config.constant_cameras = t.config.constant_intrinsics = all(kCameras);
       t.config.constant_points = all(kPoints);
     }},
    {"cameras_held",
     [](Task& t) { t.config.constant_cameras = t.config.constant_intrinsics = all(kCameras); }},
    {"points_held", [](Task& t) { t.config.constant_points = all(kPoints); }},
    {"all_but_one_camera_held",
     [](Task& t) {
       t.config.constant_cameras = t.config.constant_intrinsics = {0, 1, 3};
       t.config.constant_points = all(kPoints);
     }},
    {"one_place", stand_in_one_place},
    {"points_on_a_line",
     [](Task& t) {
       for (Eigen::Index p = 0; p < kPoints; ++p) {
         const double along = 0.1 * static_cast<double>(p - kPoints / 2);
         t.problem.points.row(p) << along, 0.5 * along, -along;
       }
     }},
    {"points_in_one_place",
     [](Task& t) { t.problem.points.rowwise() = t.problem.points.row(0).eval(); }},
    {"behind_a_camera", [](Task& t) { t.problem.points.row(3) << 0.3, 0.2, 30.0; }},
    {"far_away", [](Task& t) { t.problem.points.row(3) *= 1e9; }},
    {"in_a_camera_plane",
     [](Task& t) {
       const auto camera = t.problem.cameras.row(1);
       const Matrix3 R = so3_exp(camera.head<3>().transpose());
       t.problem.points.row(3) = (-R.transpose() * camera.segment<3>(3).transpose()).transpose();
     },
     true},
    {"nan_point",
     [](Task& t) { t.problem.points(3, 1) = std::numeric_limits<double>::quiet_NaN(); }, true},
    {"nan_camera",
     [](Task& t) { t.problem.cameras(1, 0) = std::numeric_limits<double>::quiet_NaN(); }, true},
    {"infinite_pixel",
     [](Task& t) { t.problem.observations(7, 0) = std::numeric_limits<double>::infinity(); }, true},
    {"overflow", [](Task& t) { t.problem.cameras(0, 6) = 1e200; }, true},
};

class AwkwardProblems : public testing::TestWithParam<test::NativeSolver> {};

// An unobserved point that is not finite is nobody's business, so the arrays may hold one.
void expect_what_it_says(const Task& before, const BalProblem& after, const Summary& summary) {
  const double cost = 0.5 * reprojection_residuals(BundleScene(after)).squaredNorm();
  ASSERT_TRUE(summary.is_usable()) << summary.message;
  EXPECT_TRUE(after.cameras.allFinite());
  EXPECT_TRUE(after.points.allFinite());
  EXPECT_LE(summary.final_cost, summary.initial_cost);
  EXPECT_NEAR(summary.final_cost, cost, 1e-9 * cost + 1e-18);
  for (std::int64_t p = 0; p < kPoints; ++p) {
    if ((before.problem.point_index.array() == p).any()) continue;
    EXPECT_EQ(after.points.row(p), before.problem.points.row(p)) << "unseen point " << p;
  }
  for (std::int64_t c = 0; c < kCameras; ++c) {
    if ((before.problem.camera_index.array() == c).any()) continue;
    EXPECT_EQ(after.cameras.row(c), before.problem.cameras.row(c)) << "blind camera " << c;
  }
}

void expect_clear_failure(const Task& before, const BalProblem& after, const Summary& summary) {
  EXPECT_EQ(summary.termination, Termination::FAILURE);
  EXPECT_FALSE(summary.message.empty());
  const auto same_bits = [](const auto& a, const auto& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
  };
  EXPECT_TRUE(same_bits(after.cameras, before.problem.cameras));
  EXPECT_TRUE(same_bits(after.points, before.problem.points));
}

TEST_P(AwkwardProblems, GiveAFiniteAnswerOrAClearFailure) {
  for (const Awkward& awkward : kAwkward) {
    for (const auto point : {PointParametrization::XYZ, PointParametrization::HOMOGENEOUS}) {
      SCOPED_TRACE(std::string(awkward.name) + ", " + to_string(point));
      Task task;
      awkward.spoil(task);
      BundleOptions options = GetParam().options();
      options.point_parametrization = point;
      options.lm.max_num_iterations = task.max_num_iterations;
      BalProblem problem = task.problem;
      const Summary summary = adjust(problem, task.config, options);
      (awkward.fails ? expect_clear_failure : expect_what_it_says)(task, problem, summary);
    }
  }
}

// Where the answer is known: twice the observations are twice the cost of the same minimum.
TEST_P(AwkwardProblems, ObservationsThatStandTwiceCountTwice) {
  BundleOptions options = GetParam().options();
  options.lm.max_num_iterations = 100;
  options.lm.function_tolerance = 1e-13;
  Task once;
  Task twice;
  observe_twice(twice);
  const double cost = adjust(once.problem, {}, options).final_cost;
  EXPECT_NEAR(adjust(twice.problem, {}, options).final_cost, 2.0 * cost, 1e-8 * cost);
}

INSTANTIATE_TEST_SUITE_P(Native,
                         AwkwardProblems,
                         testing::ValuesIn(test::kNativeSolvers),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace raylign
