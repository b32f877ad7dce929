// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The smallest program on top of the installed library: three cameras look at a grid of points, the
// points are disturbed, and bundle adjustment brings them back.
#include <cmath>
#include <cstdio>
#include <exception>

#include "raylign/bundle/bundle_adjuster.h"

namespace {

constexpr int kNumCameras = 3;
constexpr int kSide = 5;
constexpr double kFocal = 500.0;  // px

// BAL cameras look along -z, so a scene at z = -10 lies in front of cameras without rotation.
raylign::BalProblem make_problem() {
  raylign::BalProblem problem;
  problem.cameras.setZero(kNumCameras, 9);
  problem.points.resize(kSide * kSide, 3);
  const int num_observations = kNumCameras * kSide * kSide;
  problem.camera_index.resize(num_observations);
  problem.point_index.resize(num_observations);
  problem.observations.resize(num_observations, 2);
  for (int j = 0; j < kSide * kSide; ++j) {
    problem.points.row(j) << j % kSide - 2.0, j / kSide - 2.0, -10.0 - (j % 3);
  }
  int row = 0;
  for (int i = 0; i < kNumCameras; ++i) {
    problem.cameras(i, 3) = i - 1.0;  // t_cw: one unit of baseline between neighbours
    problem.cameras(i, 6) = kFocal;
    for (int j = 0; j < kSide * kSide; ++j, ++row) {
      const Eigen::Vector3d p_c = problem.points.row(j) + problem.cameras.row(i).segment<3>(3);
      problem.camera_index(row) = i;
      problem.point_index(row) = j;
      problem.observations.row(row) = -kFocal / p_c.z() * p_c.head<2>().transpose();
    }
  }
  return problem;
}

void disturb(raylign::BalProblem& problem) {
  for (Eigen::Index j = 0; j < problem.points.rows(); ++j) {
    const double phase = static_cast<double>(j);
    problem.points.row(j) +=
        0.2 * Eigen::RowVector3d(std::sin(phase), std::cos(phase), std::sin(2 * phase));
  }
}

int run() {
  raylign::BalProblem problem = make_problem();
  disturb(problem);

  raylign::BundleConfig config;
  config.gauge = raylign::Gauge::TWO_CAMERAS;
  raylign::BundleOptions options;
  options.loss = raylign::parse_loss("huber:1.0");
  const raylign::Summary summary = raylign::adjust(problem, config, options);

  std::puts(summary.full_report().c_str());
  return summary.is_usable() && summary.final_cost < 1e-6 * summary.initial_cost ? 0 : 1;
}

}  // namespace

int main() {
  try {
    return run();
  } catch (const std::exception& error) {  // raylign::Error for everything raised on purpose
    std::fprintf(stderr, "ba_minimal: %s\n", error.what());
    return 2;
  }
}
