// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/scene/bal_problem.h"
#include "support/named_rng.h"

namespace raylign::test {

/// Tracks of 2 … max_length cameras out of `num_cameras`, some of them seen twice by a camera; the
/// points one after the other, the cameras of each in no order. Pixels that tell the observations
/// apart; nothing else is set.
inline BalProblem random_tracks(int num_cameras, int num_points, int max_length) {
  auto rng = make_rng("random tracks");
  std::vector<int> cameras;
  std::vector<int> points;
  for (int p = 0; p < num_points; ++p) {
    const int length = rng.integer(2, max_length);
    const int first = rng.integer(0, num_cameras - 1);
    for (int k = 0; k < length; ++k) {
      cameras.push_back((first + rng.integer(0, 2 * k)) % num_cameras);
      points.push_back(p);
    }
  }
  BalProblem problem;
  problem.cameras.setZero(num_cameras, 9);
  problem.points.setZero(num_points, 3);
  const auto count = static_cast<Eigen::Index>(cameras.size());
  problem.camera_index = Eigen::Map<Eigen::VectorXi>(cameras.data(), count);
  problem.point_index = Eigen::Map<Eigen::VectorXi>(points.data(), count);
  problem.observations.resize(count, 2);
  for (Eigen::Index i = 0; i < count; ++i) problem.observations.row(i) << 1.0 * i, -1.0 * i;
  return problem;
}

}  // namespace raylign::test
