// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/canonical_world.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "raylign/geometry/quaternion.h"

namespace raylign::photometric {
namespace {

double median_distance(const PhotometricProblem& problem, const Matrix3& R, const Vector3& t) {
  std::vector<double> distances;
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    distances.push_back((R * problem.points.row(p).transpose() + t).norm());
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

bool holds_part_of_a_translation(const BundleConfig& config) {
  return std::any_of(config.constant_coordinates.begin(), config.constant_coordinates.end(),
                     [](const ConstantCoordinate& held) {
                       return held.kind == ParameterKind::POSE && held.coordinate != "rotation";
                     });
}

constexpr double kRoundingsPerUnit = 1 << 30;

double rounded(double x) { return std::round(x * kRoundingsPerUnit) / kRoundingsPerUnit; }

Vector3 rounded(const Vector3& x) { return {rounded(x[0]), rounded(x[1]), rounded(x[2])}; }

Matrix3 rounded(const Matrix3& R) {
  Quaternion q = quaternion_from_matrix(R);
  for (double& x : q.coeffs()) x = rounded(x);
  return quaternion_to_matrix(q.normalized());
}

// C of ξ = [υ; ω] when lengths are multiplied by `scale`.
void scale_pose_covariance(double scale, Eigen::Ref<RowMajor<6, 6>> C) {
  C.topRows<3>() *= scale;
  C.leftCols<3>() *= scale;
}

void set_pose(const Matrix3& R, const Vector3& t, Eigen::Index i, Rows<double, 16>& T_cw) {
  RowMajor<4, 4> T = RowMajor<4, 4>::Identity();
  T.topLeftCorner<3, 3>() = R;
  T.topRightCorner<3, 1>() = t;
  T_cw.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 16>>(T.data());
}

}  // namespace

CanonicalWorld::CanonicalWorld(const PhotometricProblem& problem,
                               const BundleConfig& config,
                               const PhotometricOptions& options) {
  if (problem.num_images() == 0 || problem.num_points() == 0) return;
  if (options.additive_damping || holds_part_of_a_translation(config)) return;
  R_0_ = problem.pose(0).topLeftCorner<3, 3>();
  t_0_ = problem.pose(0).topRightCorner<3, 1>();
  unit_ = median_distance(problem, R_0_, t_0_);
  is_used_ = unit_ > 0.0 && std::isfinite(unit_);
}

PhotometricProblem CanonicalWorld::into(const PhotometricProblem& problem) const {
  PhotometricProblem inside = problem;
  for (Eigen::Index i = 0; i < problem.T_cw.rows(); ++i) {
    const Matrix4 T = problem.pose(i);
    const Matrix3 R = T.topLeftCorner<3, 3>() * R_0_.transpose();
    const Vector3 t = (T.topRightCorner<3, 1>() - R * t_0_) / unit_;
    set_pose(rounded(R), rounded(t), i, inside.T_cw);
  }
  for (Eigen::Index p = 0; p < problem.points.rows(); ++p) {
    const Vector3 X = (R_0_ * problem.points.row(p).transpose() + t_0_) / unit_;
    inside.points.row(p) = rounded(X).transpose();
  }
  for (Eigen::Index i = 0; i < problem.pose_covariances.rows(); ++i) {
    scale_pose_covariance(1.0 / unit_,
                          Eigen::Map<RowMajor<6, 6>>(inside.pose_covariances.row(i).data()));
  }
  for (Eigen::Index p = 0; p < problem.point_covariances.rows(); ++p) {
    Eigen::Map<RowMajor<3, 3>> C(inside.point_covariances.row(p).data());
    C = (R_0_ * C * R_0_.transpose() / (unit_ * unit_)).eval();
  }
  if (problem.depth_sigmas.rows() > 0) inside.depth_sigmas /= unit_;
  return inside;
}

PhotometricOptions CanonicalWorld::into(PhotometricOptions options) const {
  options.min_depth /= unit_;
  return options;
}

void CanonicalWorld::back(const PhotometricProblem& given,
                          const PhotometricProblem& solved,
                          PhotometricResult& result) const {
  for (Eigen::Index i = 0; i < result.T_cw.rows(); ++i) {
    const RowMajor<4, 4> T = Eigen::Map<const RowMajor<4, 4>>(result.T_cw.row(i).data());
    const Matrix3 R = T.topLeftCorner<3, 3>();
    if (result.T_cw.row(i) == solved.T_cw.row(i)) {
      result.T_cw.row(i) = given.T_cw.row(i);
    } else {
      set_pose(R * R_0_, unit_ * T.topRightCorner<3, 1>() + R * t_0_, i, result.T_cw);
    }
  }
  for (Eigen::Index p = 0; p < result.points.rows(); ++p) {
    if (result.points.row(p) == solved.points.row(p)) {
      result.points.row(p) = given.points.row(p);
    } else {
      const Vector3 X = unit_ * result.points.row(p).transpose() - t_0_;
      result.points.row(p) = (R_0_.transpose() * X).transpose();
    }
  }
  for (Eigen::Index i = 0; i < result.pose_covariance.rows(); i += 6) {
    result.pose_covariance.middleRows<3>(i) *= unit_;
    result.pose_covariance.middleCols<3>(i) *= unit_;
  }
  for (Eigen::Index p = 0; p < result.point_covariances.rows(); ++p) {
    Eigen::Map<RowMajor<3, 3>> C(result.point_covariances.row(p).data());
    C = (R_0_.transpose() * C * R_0_ * (unit_ * unit_)).eval();
  }
}

}  // namespace raylign::photometric
