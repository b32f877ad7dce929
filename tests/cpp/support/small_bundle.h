// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "raylign/geometry/so3.h"
#include "raylign/scene/bundle_problem.h"
#include "support/named_rng.h"

namespace raylign::test {

/// Parameters of camera c, different for each.
inline Eigen::VectorXd small_bundle_params(CameraModel model, int c) {
  Eigen::VectorXd params(num_params(model));
  switch (model) {
    case CameraModel::BAL:
      params << 500.0 + c, -1e-2, 1e-3;
      break;
    case CameraModel::PINHOLE:
      params << 500.0 + c, 480.0 - c, 320.0 + 2 * c, 240.0;
      break;
    case CameraModel::RADTAN:
      params << 500.0 + c, 480.0 - c, 320.0 + 2 * c, 240.0, -0.1, 0.02, 1e-3, -5e-4, 0.01;
      break;
  }
  return params;
}

struct SmallBundle {
  BundleProblem truth, problem;  ///< the problem starts off the truth
};

/// Cameras on an arc around the points; every camera sees every point; pixels with `sigma` px of
/// noise.
inline SmallBundle small_bundle(CameraModel model,
                                double sigma = 0.5,
                                int num_cameras = 5,
                                int num_points = 40) {
  auto rng = make_rng("small bundle " + to_string(model));
  BundleProblem truth;
  truth.camera_model = model;
  truth.T_cw.resize(num_cameras, 16);
  truth.intrinsics.resize(num_cameras, num_params(model));
  truth.points.resize(num_points, 3);
  for (int p = 0; p < num_points; ++p) truth.points.row(p) = rng.normal_vector<3>(0.7).transpose();
  visit_camera(model, [&](auto type) {
    using Camera = typename decltype(type)::Camera;
    for (int c = 0; c < num_cameras; ++c) {
      Eigen::Map<RowMajor<4, 4>> T(truth.T_cw.row(c).data());
      T.setIdentity();
      T.template topLeftCorner<3, 3>() = so3_exp({0.02 * c, 0.25 * (c - num_cameras / 2), 0.01});
      T.template topRightCorner<3, 1>() << rng.normal(0.1), rng.normal(0.1), 6.0 * Camera::kViewZ;
      truth.intrinsics.row(c) = small_bundle_params(model, c).transpose();
    }
    const int n = num_cameras * num_points;
    truth.camera_index.resize(n);
    truth.point_index.resize(n);
    truth.observations.resize(n, 2);
    for (int i = 0; i < n; ++i) {
      const int p = truth.point_index[i] = i / num_cameras;
      const int c = truth.camera_index[i] = i % num_cameras;
      const typename Camera::Params params = truth.intrinsics.row(c).transpose();
      Vector2 uv;
      Camera(params).project(
          (truth.pose(c) * truth.points.row(p).transpose().homogeneous()).template head<3>(), uv);
      truth.observations.row(i) = (uv + rng.normal_vector<2>(sigma)).transpose();
    }
  });
  SmallBundle out{truth, truth};
  for (int p = 0; p < num_points; ++p) {
    out.problem.points.row(p) += rng.normal_vector<3>(0.05).transpose();
  }
  for (int c = 0; c < num_cameras; ++c) {
    Eigen::Map<RowMajor<4, 4>> T(out.problem.T_cw.row(c).data());
    T.topLeftCorner<3, 3>() =
        (so3_exp(rng.normal_vector<3>(0.01)) * truth.pose(c).topLeftCorner<3, 3>()).eval();
    T.topRightCorner<3, 1>() += rng.normal_vector<3>(0.01);
  }
  return out;
}

}  // namespace raylign::test
