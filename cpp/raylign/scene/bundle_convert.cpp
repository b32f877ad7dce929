// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "raylign/base/error.h"
#include "raylign/geometry/quaternion.h"
#include "raylign/scene/bal_transform.h"
#include "raylign/scene/bundle_problem.h"

namespace raylign {
namespace {

// (x, y, z) → (x, −y, −z) between a camera that looks along −z with v up and one along +z with v
// down. It is its own inverse.
void turn_about_x(Rows<double, 16>& T_cw) {
  T_cw.middleCols<8>(4) *= -1.0;  // rows y and z of each 4x4
}

[[noreturn]] void refuse(std::int64_t camera, const std::string& rule) {
  throw OptionsError("camera " + std::to_string(camera) + " cannot be converted: " + rule);
}

// Column k of (f, k1, k2) in the parameters of `model`; −1: the model has none.
int column_of(CameraModel model, int k) {
  if (k == 0 || model == CameraModel::BAL) return k;
  return model == CameraModel::RADTAN ? 3 + k : -1;
}

void check_is_bal(const BundleProblem& problem) {
  for (std::int64_t i = 0; i < problem.num_cameras(); ++i) {
    const auto row = problem.intrinsics.row(i);
    if (!(row[0] == row[1])) refuse(i, "a BAL camera needs fx = fy");
    if (problem.camera_model == CameraModel::RADTAN && !row.tail(3).isZero(0.0)) {
      refuse(i, "a BAL camera needs p1 = p2 = k3 = 0");
    }
  }
}

}  // namespace

BundleProblem to_bundle_problem(const BalProblem& problem, CameraModel model) {
  problem.validate();
  BundleProblem out;
  out.camera_model = model;
  out.T_cw = camera_poses(problem);
  out.intrinsics.setZero(problem.num_cameras(), num_params(model));
  for (int k = 0; k < 3; ++k) {
    const int column = column_of(model, k);
    if (column >= 0) out.intrinsics.col(column) = problem.cameras.col(6 + k);
  }
  out.points = problem.points;
  out.camera_index = problem.camera_index;
  out.point_index = problem.point_index;
  out.observations = problem.observations;
  out.colors = problem.colors;
  if (model == CameraModel::BAL) return out;
  for (std::int64_t i = 0; i < problem.num_cameras() && model == CameraModel::PINHOLE; ++i) {
    if (!problem.cameras.row(i).tail<2>().isZero(0.0)) refuse(i, "a pinhole needs k1 = k2 = 0");
  }
  out.intrinsics.col(1) = out.intrinsics.col(0);  // fy
  turn_about_x(out.T_cw);
  out.observations.col(1) *= -1.0;
  return out;
}

BalProblem to_bal_problem(const BundleProblem& problem) {
  problem.validate();
  const bool is_bal = problem.camera_model == CameraModel::BAL;
  if (!is_bal) check_is_bal(problem);
  Rows<double, 16> T_cw = problem.T_cw;
  if (!is_bal) turn_about_x(T_cw);
  BalProblem out;
  out.cameras.setZero(problem.num_cameras(), 9);
  for (std::int64_t i = 0; i < problem.num_cameras(); ++i) {
    const RowMajor<4, 4> T = Eigen::Map<const RowMajor<4, 4>>(T_cw.row(i).data());
    const Quaternion q = quaternion_from_matrix(T.topLeftCorner<3, 3>());
    out.cameras.row(i).head<3>() = quaternion_log(q).transpose();
    out.cameras.row(i).segment<3>(3) = T.topRightCorner<3, 1>().transpose();
  }
  for (int k = 0; k < 3; ++k) {
    const int column = column_of(problem.camera_model, k);
    if (column >= 0) out.cameras.col(6 + k) = problem.intrinsics.col(column);
  }
  out.points = problem.points;
  out.camera_index = problem.camera_index;
  out.point_index = problem.point_index;
  out.observations = problem.observations;
  out.colors = problem.colors;
  if (is_bal) return out;
  for (std::int64_t i = 0; i < problem.num_observations(); ++i) {
    const auto row = problem.intrinsics.row(problem.camera_index[i]);
    out.observations(i, 0) -= row[2];
    out.observations(i, 1) = row[3] - out.observations(i, 1);
  }
  return out;
}

}  // namespace raylign
