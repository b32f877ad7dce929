// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raylign/base/error.h"
#include "support/small_problem.h"

namespace raylign::test {
namespace {

// One camera at the origin that looks along −z, one point two units ahead and one to the side.
BalProblem one_observation() {
  BalProblem problem;
  problem.cameras.setZero(1, 9);
  problem.cameras.row(0).tail<3>() << 100.0, 0.1, 0.01;
  problem.points.resize(1, 3);
  problem.points << 1.0, 0.0, -2.0;
  problem.camera_index.setZero(1);
  problem.point_index.setZero(1);
  problem.observations.setZero(1, 2);
  return problem;
}

TEST(BalStatistics, ResidualIsPredictedMinusObserved) {
  BalProblem problem = one_observation();
  problem.observations << 50.0, 1.0;
  // p = (0.5, 0), r² = 0.25: u = 100 (1 + 0.1 / 4 + 0.01 / 16) 0.5.
  const Rows<double, 2> residuals = reprojection_residuals(problem);
  EXPECT_NEAR(residuals(0, 0), 1.28125, 1e-13);
  EXPECT_NEAR(residuals(0, 1), -1.0, 1e-13);
  EXPECT_NEAR(reprojection_cost(problem), 0.5 * (1.28125 * 1.28125 + 1.0), 1e-13);
  EXPECT_DOUBLE_EQ(depths(problem)[0], 2.0);
}

TEST(BalStatistics, BehindTheCameraProjectsThroughTheCentre) {
  BalProblem problem = one_observation();
  problem.points(0, 2) = 2.0;
  EXPECT_NEAR(reprojection_residuals(problem)(0, 0), -51.28125, 1e-13);
  EXPECT_DOUBLE_EQ(depths(problem)[0], -2.0);
  EXPECT_EQ(statistics(problem).num_behind_camera, 1);
}

TEST(BalStatistics, OnTheCameraPlaneIsNotFinite) {
  BalProblem problem = one_observation();
  problem.points(0, 2) = 0.0;
  EXPECT_TRUE(std::isnan(reprojection_residuals(problem)(0, 0)));
  const ProblemStatistics result = statistics(problem);
  EXPECT_EQ(result.num_non_finite, 1);
  EXPECT_EQ(result.num_behind_camera, 1);
  EXPECT_EQ(result.cost, 0.0);
}

TEST(BalStatistics, CountsAndHistogram) {
  BalProblem problem = small_problem(5, 40);  // every point seen five times
  problem.point_index[0] = 1;                 // point 0 loses one, point 1 gets camera 0 twice
  const ProblemStatistics result = statistics(problem);
  EXPECT_EQ(result.track_length_histogram, (std::vector<std::int64_t>{0, 0, 0, 0, 1, 38, 1}));
  EXPECT_EQ(result.num_duplicate_observations, 1);
  EXPECT_EQ(result.observations_per_point.min, 4.0);
  EXPECT_EQ(result.observations_per_point.max, 6.0);
  EXPECT_EQ(result.observations_per_point.median, 5.0);
  EXPECT_EQ(result.observations_per_point.mean, 5.0);
  EXPECT_EQ(result.observations_per_camera.mean, 40.0);
  EXPECT_EQ(result.num_unobserved_points, 0);
  EXPECT_NEAR(result.rmse, std::sqrt(2.0 * result.cost / 400.0), 1e-12);
}

TEST(BalStatistics, DuplicatesKnowTheirFirstOccurrence) {
  BalProblem problem = small_problem(5, 40);
  problem.camera_index[9] = problem.camera_index[7];  // 5..9 belong to point 1
  problem.camera_index[8] = problem.camera_index[7];
  problem.camera_index[199] = problem.camera_index[195];
  const auto duplicates = duplicate_observations(problem);
  ASSERT_EQ(duplicates.size(), 3u);
  EXPECT_EQ(duplicates[0].first, 7);
  EXPECT_EQ(duplicates[0].repeat, 8);
  EXPECT_EQ(duplicates[1].first, 7);
  EXPECT_EQ(duplicates[1].repeat, 9);
  EXPECT_EQ(duplicates[2].first, 195);
  EXPECT_EQ(duplicates[2].repeat, 199);
}

TEST(BalStatistics, EmptyProblem) {
  const ProblemStatistics result = statistics(BalProblem{});
  EXPECT_EQ(result.num_observations, 0);
  EXPECT_EQ(result.rmse, 0.0);
  EXPECT_TRUE(result.track_length_histogram.empty());
}

TEST(BalStatistics, BrokenIndicesAreRefused) {
  BalProblem problem = small_problem();
  problem.point_index[0] = -1;
  EXPECT_THROW(statistics(problem), ShapeError);
  EXPECT_THROW(reprojection_cost(problem), ShapeError);
  EXPECT_THROW(duplicate_observations(problem), ShapeError);
}

}  // namespace
}  // namespace raylign::test
