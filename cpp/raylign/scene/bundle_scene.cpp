// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bundle_scene.h"

#include <limits>
#include <vector>

#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/so3.h"
#include "raylign/scene/problem_checks.h"

namespace raylign {
namespace {

template <typename Problem>
const Problem& validated(const Problem& problem) {
  problem.validate();
  return problem;
}

// The nearest rotation to a matrix that is one to rounding, as a rotation vector.
Vector3 angle_axis_of(const BundleProblem& problem, std::int64_t i) {
  const Matrix3 R = problem.pose(i).topLeftCorner<3, 3>();
  return quaternion_log(quaternion_from_matrix(R));
}

template <typename Camera>
struct PosedCamera {
  Matrix3 R_cw;
  Vector3 t_cw;
  Camera camera;
};

// Rotations and cameras are built once, not once per observation.
template <typename Camera>
std::vector<PosedCamera<Camera>> posed_cameras(const BundleScene& scene) {
  std::vector<PosedCamera<Camera>> cameras;
  cameras.reserve(scene.num_cameras());
  for (std::int64_t c = 0; c < scene.num_cameras(); ++c) {
    const typename Camera::Params params = scene.intrinsics.row(c).transpose();
    cameras.push_back(
        {so3_exp(scene.omega.row(c).transpose()), scene.t.row(c).transpose(), Camera(params)});
  }
  return cameras;
}

// Calls visit(i, residual) for each observation.
template <typename Visitor>
void for_each_residual(const BundleScene& scene, const Visitor& visit) {
  visit_camera(scene.camera_model, [&](auto type) {
    const auto cameras = posed_cameras<typename decltype(type)::Camera>(scene);
    for (std::int64_t i = 0; i < scene.num_observations(); ++i) {
      const auto& camera = cameras[scene.camera_index[i]];
      const Vector3 X = scene.points.row(scene.point_index[i]).transpose();
      Vector2 predicted;
      if (!camera.camera.project(camera.R_cw * X + camera.t_cw, predicted)) {
        predicted.setConstant(std::numeric_limits<double>::quiet_NaN());
      }
      visit(i, Vector2(predicted - scene.observations.row(i).transpose()));
    }
  });
}

}  // namespace

BundleScene::BundleScene(const BalProblem& problem)
    : camera_model(CameraModel::BAL),
      omega(validated(problem).cameras.leftCols<3>()),
      t(problem.cameras.middleCols<3>(3)),
      intrinsics(problem.cameras.rightCols<3>()),
      points(problem.points),
      camera_index(problem.camera_index),
      point_index(problem.point_index),
      observations(problem.observations) {}

BundleScene::BundleScene(const BundleProblem& problem)
    : camera_model(validated(problem).camera_model),
      omega(problem.num_cameras(), 3),
      t(problem.num_cameras(), 3),
      intrinsics(problem.intrinsics),
      points(problem.points),
      camera_index(problem.camera_index),
      point_index(problem.point_index),
      observations(problem.observations) {
  for (std::int64_t i = 0; i < problem.num_cameras(); ++i) {
    omega.row(i) = angle_axis_of(problem, i).transpose();
    t.row(i) = problem.pose(i).topRightCorner<3, 1>().transpose();
  }
}

void BundleScene::store(BalProblem& problem) const {
  problem.cameras.leftCols<3>() = omega;
  problem.cameras.middleCols<3>(3) = t;
  problem.cameras.rightCols<3>() = intrinsics;
  problem.points = points;
}

void BundleScene::store(BundleProblem& problem) const {
  for (std::int64_t i = 0; i < num_cameras(); ++i) {
    Eigen::Map<RowMajor<4, 4>> T_cw(problem.T_cw.row(i).data());
    const Vector3 phi = omega.row(i).transpose();
    if (!same_bits(phi, angle_axis_of(problem, i))) T_cw.topLeftCorner<3, 3>() = so3_exp(phi);
    T_cw.topRightCorner<3, 1>() = t.row(i).transpose();
  }
  problem.intrinsics = intrinsics;
  problem.points = points;
}

Rows<double, 3> camera_centers(const BundleScene& scene) {
  Rows<double, 3> centers(scene.num_cameras(), 3);
  for (std::int64_t i = 0; i < scene.num_cameras(); ++i) {
    const Matrix3 R_cw = so3_exp(scene.omega.row(i).transpose());
    centers.row(i) = -scene.t.row(i) * R_cw;  // (Rᵀ t)ᵀ = tᵀ R
  }
  return centers;
}

Rows<double, 2> reprojection_residuals(const BundleScene& scene) {
  Rows<double, 2> residuals(scene.num_observations(), 2);
  for_each_residual(scene,
                    [&](std::int64_t i, const Vector2& r) { residuals.row(i) = r.transpose(); });
  return residuals;
}

Rows<double, 1> depths(const BundleScene& scene) {
  const double view_z =
      visit_camera(scene.camera_model, [](auto type) { return decltype(type)::Camera::kViewZ; });
  Rows<double, 3> axes(scene.num_cameras(), 3);  // third row of R_cw
  for (std::int64_t c = 0; c < scene.num_cameras(); ++c) {
    axes.row(c) = so3_exp(scene.omega.row(c).transpose()).row(2);
  }
  Rows<double, 1> result(scene.num_observations());
  for (std::int64_t i = 0; i < scene.num_observations(); ++i) {
    const std::int32_t c = scene.camera_index[i];
    result[i] = view_z * (axes.row(c).dot(scene.points.row(scene.point_index[i])) + scene.t(c, 2));
  }
  return result;
}

double reprojection_cost(const BundleScene& scene) {
  double sum = 0.0;
  for_each_residual(scene, [&](std::int64_t, const Vector2& r) { sum += r.squaredNorm(); });
  return 0.5 * sum;
}

}  // namespace raylign
