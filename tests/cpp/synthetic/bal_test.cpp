// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/bal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "raylign/base/error.h"
#include "raylign/io/bal.h"
#include "raylign/scene/bal_statistics.h"
#include "raylign/synthetic/write_bal.h"

namespace raylign {
namespace {

SyntheticBalOptions make_options(SyntheticBalKind kind,
                                 int num_cameras = 60,
                                 int num_points = 4000) {
  SyntheticBalOptions options;
  options.kind = kind;
  options.num_cameras = num_cameras;
  options.num_points = num_points;
  options.seed = 5;
  return options;
}

// Number of connected components of the graph camera – point – camera.
int num_components(const BalProblem& problem) {
  std::vector<int> parent(problem.num_cameras() + problem.num_points());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  auto components = static_cast<int>(parent.size());
  for (Eigen::Index i = 0; i < problem.num_observations(); ++i) {
    const int a = root(problem.camera_index[i]);
    const int b = root(static_cast<int>(problem.num_cameras()) + problem.point_index[i]);
    if (a != b) --components;
    parent[a] = b;
  }
  return components;
}

class SyntheticBalTest : public testing::TestWithParam<SyntheticBalKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds,
                         SyntheticBalTest,
                         testing::Values(SyntheticBalKind::STREET, SyntheticBalKind::ORBIT));

TEST_P(SyntheticBalTest, TruthWithoutNoiseHasNoResidual) {
  SyntheticBalOptions options = make_options(GetParam());
  options.pixel_noise = 0.0;
  options.far_fraction = 0.1;
  const BalProblem truth = synthetic_bal(options).truth;
  EXPECT_LE(reprojection_residuals(truth).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(depths(truth).minCoeff(), 0.0);
  EXPECT_LE(truth.observations.col(0).cwiseAbs().maxCoeff(), 320.0);
  EXPECT_LE(truth.observations.col(1).cwiseAbs().maxCoeff(), 240.0);
}

TEST_P(SyntheticBalTest, CountsAreExact) {
  SyntheticBalOptions options = make_options(GetParam(), 170, 5001);
  options.num_observations = 20017;
  const SyntheticBal bal = synthetic_bal(options);
  EXPECT_EQ(bal.problem.num_cameras(), 170);
  EXPECT_EQ(bal.problem.num_points(), 5001);
  EXPECT_EQ(bal.problem.num_observations(), 20017);
  EXPECT_EQ(bal.inlier_mask.size(), 20017);
  EXPECT_NO_THROW(bal.problem.validate());
  EXPECT_NO_THROW(bal.truth.validate());
}

TEST_P(SyntheticBalTest, EveryPointTwiceAndTheGraphIsConnected) {
  for (const int num_cameras : {2, 3, 7, 16, 41, 60, 211}) {
    for (const int views : {1, 4, 8}) {
      for (const std::uint64_t seed : {0, 1, 2}) {
        SyntheticBalOptions options = make_options(GetParam(), num_cameras, 20 * num_cameras);
        options.views_per_stop = views;
        options.seed = seed;
        const BalProblem problem = synthetic_bal(options).problem;
        const ProblemStatistics s = statistics(problem);
        EXPECT_GE(s.observations_per_point.min, 2);
        EXPECT_GE(s.observations_per_camera.min, 12);  // 20 · 0.75 / 1.25 as reference camera
        EXPECT_EQ(s.num_duplicate_observations, 0);
        EXPECT_EQ(num_components(problem), 1) << num_cameras << " cameras, " << views << " views";
      }
    }
  }
}

TEST_P(SyntheticBalTest, TheSparsestGraphIsConnectedToo) {
  SyntheticBalOptions options = make_options(GetParam(), 200, 800);
  options.mean_track_length = 2.0;
  options.loop_closure_fraction = 0.0;
  const BalProblem problem = synthetic_bal(options).problem;
  EXPECT_EQ(problem.num_observations(), 1600);
  EXPECT_EQ(num_components(problem), 1);
}

TEST_P(SyntheticBalTest, ObservationsAreSortedByPointThenCamera) {
  const BalProblem problem = synthetic_bal(make_options(GetParam())).problem;
  for (Eigen::Index i = 1; i < problem.num_observations(); ++i) {
    const auto key = [&](Eigen::Index k) {
      return std::make_pair(problem.point_index[k], problem.camera_index[k]);
    };
    ASSERT_LT(key(i - 1), key(i));
  }
}

TEST_P(SyntheticBalTest, TrackLengthsHaveAHeavyTail) {
  SyntheticBalOptions options = make_options(GetParam(), 400, 20000);
  options.mean_track_length = 5.0;
  const ProblemStatistics s = statistics(synthetic_bal(options).problem);
  EXPECT_NEAR(s.observations_per_point.mean, 5.0, 1e-9 + 1.0 / 20000);
  EXPECT_LE(s.observations_per_point.median, 4.0);
  EXPECT_GE(s.observations_per_point.max, 30.0);
  const auto& histogram = s.track_length_histogram;
  const auto short_tracks = histogram[2] + histogram[3] + histogram[4];
  EXPECT_GT(short_tracks, 20000 / 2);
  EXPECT_GT(histogram[2], histogram[3]);
  EXPECT_GT(histogram[3], histogram[4]);
}

TEST_P(SyntheticBalTest, TheSeedDecidesAlone) {
  SyntheticBalOptions options = make_options(GetParam());
  options.outlier_fraction = 0.05;
  const SyntheticBal a = synthetic_bal(options);
  const SyntheticBal b = synthetic_bal(options);
  EXPECT_TRUE(a.problem == b.problem);
  EXPECT_TRUE(a.truth == b.truth);
  options.seed = 6;
  const SyntheticBal other = synthetic_bal(options);
  EXPECT_FALSE(a.truth.points == other.truth.points);
  EXPECT_FALSE(a.truth.cameras == other.truth.cameras);
}

TEST_P(SyntheticBalTest, NoiseKnobsLeaveTheSceneAlone) {
  SyntheticBalOptions options = make_options(GetParam());
  const SyntheticBal a = synthetic_bal(options);
  options.pixel_noise = 2.0;
  options.outlier_fraction = 0.1;
  options.rotation_noise_deg = 3.0;
  options.point_noise = 0.1;
  const SyntheticBal b = synthetic_bal(options);
  EXPECT_TRUE(a.truth.points == b.truth.points);
  EXPECT_TRUE(a.truth.cameras == b.truth.cameras);
  EXPECT_TRUE(a.truth.camera_index == b.truth.camera_index);
  EXPECT_FALSE(a.problem.points == b.problem.points);
}

TEST_P(SyntheticBalTest, ChunksDoNotMatter) {
  SyntheticBalOptions options = make_options(GetParam());
  options.outlier_fraction = 0.05;
  const SyntheticBal bal = synthetic_bal(options);
  SyntheticBalStream stream(options);
  SyntheticObservationChunk observations;
  SyntheticPointChunk points;
  Eigen::Index row = 0;
  Eigen::Index point = 0;
  while (stream.next_points(7, points)) {  // before and between the observations
    for (const Vector3& p : points.start) ASSERT_EQ(p, bal.problem.points.row(point++).transpose());
    if (!stream.next_observations(3, observations)) continue;
    for (const Vector2& uv : observations.observations) {
      ASSERT_EQ(uv, bal.problem.observations.row(row++).transpose());
    }
  }
  while (stream.next_observations(100, observations)) row += observations.observations.size();
  EXPECT_EQ(point, bal.problem.num_points());
  EXPECT_EQ(row, bal.problem.num_observations());
}

TEST_P(SyntheticBalTest, TheStreamedFileReadsBackBitForBit) {
  SyntheticBalOptions options = make_options(GetParam(), 20, 600);
  options.outlier_fraction = 0.05;
  SyntheticBal bal = synthetic_bal(options);
  SyntheticBalStream stream(options);
  std::string texts[2];
  BalWriter problem(make_string_sink(&texts[0]), 20, 600, stream.num_observations());
  BalWriter truth(make_string_sink(&texts[1]), 20, 600, stream.num_observations());
  write_synthetic_bal(stream, problem, &truth);
  problem.finish();
  truth.finish();
  bal.problem.colors.resize(0, 3);
  bal.truth.colors.resize(0, 3);
  EXPECT_TRUE(parse_bal(texts[0]) == bal.problem);
  EXPECT_TRUE(parse_bal(texts[1]) == bal.truth);
}

TEST_P(SyntheticBalTest, ProgressCanStopTheWriter) {
  const SyntheticBalOptions options = make_options(GetParam(), 60, 10000);
  SyntheticBalStream stream(options);
  std::string text;
  BalWriter writer(make_string_sink(&text), 60, 10000, stream.num_observations());
  std::int64_t seen = 0;
  const auto stop = [&](std::int64_t done, std::int64_t total) {
    EXPECT_EQ(total, stream.num_observations());
    seen = done;
    return false;
  };
  EXPECT_THROW(write_synthetic_bal<BalWriter>(stream, writer, nullptr, stop), Error);
  EXPECT_GT(seen, 0);
  EXPECT_LT(seen, stream.num_observations());
}

TEST_P(SyntheticBalTest, PixelNoiseAndOutliersHaveTheirStatistics) {
  SyntheticBalOptions options = make_options(GetParam());
  options.pixel_noise = 0.8;
  options.outlier_fraction = 0.1;
  const SyntheticBal bal = synthetic_bal(options);
  const Rows<double, 2> residuals = reprojection_residuals(bal.truth);
  double squares = 0.0;
  double sum = 0.0;
  double count = 0.0;
  for (Eigen::Index i = 0; i < residuals.rows(); ++i) {
    if (bal.inlier_mask[i] == 0) continue;
    squares += residuals.row(i).squaredNorm();
    sum += residuals.row(i).sum();
    count += 2.0;
  }
  // Five standard errors each.
  EXPECT_NEAR(sum / count, 0.0, 5.0 * 0.8 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.8, 5.0 * 0.8 / std::sqrt(2.0 * count));
  const auto n = static_cast<double>(bal.inlier_mask.size());
  EXPECT_NEAR(1.0 - bal.inlier_mask.cast<double>().sum() / n, 0.1, 5.0 * std::sqrt(0.09 / n));
}

TEST_P(SyntheticBalTest, AStartWithoutPerturbationIsTheTruth) {
  SyntheticBalOptions options = make_options(GetParam());
  options.rotation_noise_deg = options.translation_noise = options.point_noise = 0.0;
  options.focal_noise = options.distortion_noise = 0.0;
  const SyntheticBal bal = synthetic_bal(options);
  EXPECT_TRUE(bal.problem == bal.truth);
}

TEST_P(SyntheticBalTest, FarPointsReachTheirDepth) {
  SyntheticBalOptions options = make_options(GetParam());
  options.far_fraction = 0.3;
  options.far_factor = 1e6;
  const BalProblem truth = synthetic_bal(options).truth;
  const double far = (truth.points.rowwise().norm().array() > 150.0).cast<double>().mean();
  EXPECT_NEAR(far, 0.3, 5.0 * std::sqrt(0.21 / static_cast<double>(truth.num_points())));
  EXPECT_GT(truth.points.rowwise().norm().maxCoeff(), 1e6);
}

TEST(SyntheticBal, LoopClosuresJoinTheLaps) {
  SyntheticBalOptions options = make_options(SyntheticBalKind::STREET, 240, 6000);
  const auto cross_lap = [&](double fraction) {
    options.loop_closure_fraction = fraction;
    const BalProblem problem = synthetic_bal(options).problem;
    int count = 0;
    for (Eigen::Index i = 1; i < problem.num_observations(); ++i) {
      if (problem.point_index[i] != problem.point_index[i - 1]) continue;
      count += problem.camera_index[i] >= 120 && problem.camera_index[i - 1] < 120;
    }
    return count;
  };
  const int none = cross_lap(0.0);
  EXPECT_GE(none, 1);  // the graph stays connected
  EXPECT_LE(none, 120);
  EXPECT_GT(cross_lap(0.3), 600);
}

}  // namespace
}  // namespace raylign
