// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/camera/bal.h"
#include "raylign/geometry/so3.h"
#include "raylign/scene/bal_problem.h"
#include "support/named_rng.h"

namespace raylign::test {

/// `num_cameras` cameras on an arc around `num_points` points; every camera sees every point. Start
/// perturbed, pixels with half a pixel of noise.
inline BalProblem small_problem(int num_cameras = 5, int num_points = 40) {
  auto rng = make_rng("small problem");
  BalProblem problem;
  problem.cameras.resize(num_cameras, 9);
  problem.points.resize(num_points, 3);
  for (int p = 0; p < num_points; ++p)
    problem.points.row(p) = rng.normal_vector<3>(0.7).transpose();
  for (int c = 0; c < num_cameras; ++c) {
    const double angle = 0.25 * (c - num_cameras / 2);
    problem.cameras.row(c) << 0.02 * c, angle, 0.01, rng.normal(0.1), rng.normal(0.1), -6.0, 500.0,
        -1e-2, 1e-3;
  }
  const int n = num_cameras * num_points;
  problem.camera_index.resize(n);
  problem.point_index.resize(n);
  problem.observations.resize(n, 2);
  for (int i = 0; i < n; ++i) {
    const int p = problem.point_index[i] = i / num_cameras;
    const int c = problem.camera_index[i] = i % num_cameras;
    const Eigen::Matrix<double, 9, 1> camera = problem.cameras.row(c).transpose();
    Vector2 uv;
    BalCamera(camera[6], camera[7], camera[8])
        .project(
            so3_exp(camera.head<3>()) * problem.points.row(p).transpose() + camera.segment<3>(3),
            uv);
    problem.observations.row(i) = (uv + rng.normal_vector<2>(0.5)).transpose();
  }
  for (int p = 0; p < num_points; ++p)
    problem.points.row(p) += rng.normal_vector<3>(0.05).transpose();
  for (int c = 0; c < num_cameras; ++c) {
    problem.cameras.row(c).head<6>() += rng.normal_vector<6>(0.01).transpose();
  }
  return problem;
}

}  // namespace raylign::test
