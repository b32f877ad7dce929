// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_transform.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/geometry/so3.h"

namespace raylign {
namespace {

struct Similarity {
  double scale;
  Matrix3 R;
  Vector3 t;
};

Similarity split_similarity(const Matrix4& S) {
  const double scale = S.col(0).head<3>().stableNorm();  // no overflow at 1e200
  const Matrix3 R = S.topLeftCorner<3, 3>() / scale;
  const bool valid = S.allFinite() && R.determinant() > 0.0 &&
                     S.row(3) == Vector4::UnitW().transpose() &&
                     (R.transpose() * R - Matrix3::Identity()).cwiseAbs().maxCoeff() < 1e-9;
  if (!valid) throw ShapeError("not a similarity: the matrix must be [s R, t; 0 0 0 1] with s > 0");
  return {scale, R, S.topRightCorner<3, 1>()};
}

// nth_element must never see a NaN (it may run past the end): only finite points are asked.
std::vector<Vector3> finite_points(const Rows<double, 3>& points) {
  std::vector<Vector3> finite;
  finite.reserve(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (points.row(i).allFinite()) finite.emplace_back(points.row(i).transpose());
  }
  return finite;
}

template <typename Value>
double median_over(const std::vector<Vector3>& points, Value value) {
  std::vector<double> values(points.size());
  std::transform(points.begin(), points.end(), values.begin(), value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Matrix3 rotation_of(const BalProblem& problem, Eigen::Index camera) {
  return so3_exp(problem.cameras.row(camera).head<3>().transpose());
}

}  // namespace

BalProblem transform(const BalProblem& problem, const Matrix4& S_nw) {
  const Similarity S = split_similarity(S_nw);
  const bool turns = S_nw.topLeftCorner<3, 3>() != Matrix3(S_nw(0, 0) * Matrix3::Identity());
  const double scale = turns ? S.scale : S_nw(0, 0);
  BalProblem result = problem;
  result.points = scale * problem.points;
  if (turns) result.points *= S.R.transpose();
  result.points.rowwise() += S.t.transpose();
  for (Eigen::Index c = 0; c < problem.cameras.rows(); ++c) {
    Matrix3 R_cn = rotation_of(problem, c);
    if (turns) {
      R_cn *= S.R.transpose();
      result.cameras.row(c).head<3>() = so3_log(R_cn).transpose();
    }
    result.cameras.row(c).segment<3>(3) =
        scale * problem.cameras.row(c).segment<3>(3) - (R_cn * S.t).transpose();
  }
  return result;
}

Matrix4 inverse_similarity(const Matrix4& S_ab) {
  const Similarity S = split_similarity(S_ab);
  Matrix4 inverse = Matrix4::Identity();
  inverse.topLeftCorner<3, 3>() = S.R.transpose() / S.scale;
  inverse.topRightCorner<3, 1>() = -(S.R.transpose() * S.t) / S.scale;
  return inverse;
}

SceneExtent scene_extent(const BalProblem& problem) {
  SceneExtent scene;
  const std::vector<Vector3> points = finite_points(problem.points);
  if (points.empty()) return scene;
  for (int axis = 0; axis < 3; ++axis) {
    scene.center[axis] = median_over(points, [axis](const Vector3& p) { return p[axis]; });
  }
  scene.deviation =
      median_over(points, [&scene](const Vector3& p) { return (p - scene.center).lpNorm<1>(); });
  return scene;
}

NormalizedProblem normalize(const BalProblem& problem, double extent) {
  if (!(extent > 0.0) || !std::isfinite(extent)) {
    throw OptionsError("normalize: extent must be finite and > 0, got " + format_double(extent));
  }
  NormalizedProblem result{{}, Matrix4::Identity()};
  const SceneExtent scene = scene_extent(problem);
  double scale = extent / scene.deviation;
  const bool scales =
      std::isnormal(scale) && std::isnormal(1.0 / scale) && (scale * scene.center).allFinite();
  if (!scales) scale = 1.0;  // no extent, or one near the limits of double
  result.S_nw.topLeftCorner<3, 3>() *= scale;
  result.S_nw.topRightCorner<3, 1>() = -scale * scene.center;
  result.problem = transform(problem, result.S_nw);
  return result;
}

Rows<double, 16> camera_poses(const BalProblem& problem) {
  Rows<double, 16> poses(problem.num_cameras(), 16);
  for (Eigen::Index c = 0; c < poses.rows(); ++c) {
    Eigen::Map<RowMajor<4, 4>> T_cw(poses.row(c).data());
    T_cw.setIdentity();
    T_cw.topLeftCorner<3, 3>() = rotation_of(problem, c);
    T_cw.topRightCorner<3, 1>() = problem.cameras.row(c).segment<3>(3).transpose();
  }
  return poses;
}

}  // namespace raylign
