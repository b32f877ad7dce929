// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/umeyama.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <string>

#include "raylign/base/error.h"

namespace raylign {
namespace {

// The second singular value of the covariance, relative to the first, below which points count as
// collinear: coordinates then agree with a line to about 1e-7 of their extent.
constexpr double kCollinear = 1e-14;

void check_sizes(const Rows<double, 3>& source, const Rows<double, 3>& target) {
  if (source.rows() != target.rows() || source.rows() < 3) {
    throw ShapeError("umeyama: source and target must have the same number of points, >= 3; got " +
                     std::to_string(source.rows()) + " and " + std::to_string(target.rows()));
  }
}

}  // namespace

Matrix4 umeyama(const Rows<double, 3>& source, const Rows<double, 3>& target, bool with_scale) {
  check_sizes(source, target);
  const double n = static_cast<double>(source.rows());
  const Vector3 mean_source = source.colwise().mean().transpose();
  const Vector3 mean_target = target.colwise().mean().transpose();
  const Rows<double, 3> centred_source = source.rowwise() - mean_source.transpose();
  const Rows<double, 3> centred_target = target.rowwise() - mean_target.transpose();
  const Matrix3 covariance = centred_target.transpose() * centred_source / n;  // eq. (38)
  if (!covariance.allFinite()) throw Error("umeyama: points must be finite and not overflow");
  const Eigen::JacobiSVD<Matrix3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3 singular = svd.singularValues();
  if (!(singular[1] > kCollinear * singular[0])) {
    throw Error("umeyama: points on a line (or in one place) do not determine a rotation");
  }
  // eq. (43): without it the optimum over orthogonal matrices may be a reflection.
  Vector3 sign = Vector3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
  const Matrix3 R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();  // eq. (40)
  const double variance = centred_source.squaredNorm() / n;
  const double scale = with_scale ? singular.dot(sign) / variance : 1.0;  // eq. (42)
  Matrix4 S = Matrix4::Identity();
  S.topLeftCorner<3, 3>() = scale * R;
  S.topRightCorner<3, 1>() = mean_target - scale * R * mean_source;  // eq. (41)
  return S;
}

}  // namespace raylign
