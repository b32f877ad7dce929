// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/depth_agreement.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace raylign {
namespace {

constexpr int kMinPoints = 20;
constexpr int kEnoughPoints = 500;  // for a step of six numbers
// Half the base of the slope of the depth image, px of 640.
constexpr double kBaseShare = 4.0 / 640.0;
// Of a smooth surface the depth bends by less between three pixels of that base.
constexpr double kMaxBend = 0.03;
// A pixel is not the very point that lands in it: on a slope the depth differs, by this much per
// unit of the slope (m).
constexpr double kOffPixel = 0.002;
constexpr double kHuber = 2.0;
constexpr double kPriorSigma = 0.02;  // share of the mean depth; rad
constexpr int kSteps = 2;

// One point: what it misses the surface by, and how that changes with the pose, over σ.
struct Row {
  Vector6 J;
  double r;
};

// False where the depth image has no slope.
bool slope_at(const SensedDepth& sensed, int u, int v, double z, double& du, double& dv) {
  const int base = std::max(1, static_cast<int>(std::lround(kBaseShare * sensed.image.width)));
  if (u < base || v < base || u >= sensed.image.width - base || v >= sensed.image.height - base) {
    return false;
  }
  const double left = sensed.at(u - base, v);
  const double right = sensed.at(u + base, v);
  const double above = sensed.at(u, v - base);
  const double below = sensed.at(u, v + base);
  for (const double other : {left, right, above, below}) {
    if (!(std::abs(other - z) < sensed.max_difference * z)) return false;
  }
  if (std::abs(left + right - 2.0 * z) > kMaxBend * z) return false;
  if (std::abs(above + below - 2.0 * z) > kMaxBend * z) return false;
  du = 0.5 * (right - left) / base;
  dv = 0.5 * (below - above) / base;
  return true;
}

Row row_of(const Vector3& X,
           double z,
           double du,
           double dv,
           const PinholeCamera& camera,
           const DepthModel& model) {
  // Z − z(u, v) by X
  const double gx = du * camera.fx() / X.z();
  const double gy = dv * camera.fy() / X.z();
  const Vector3 normal(-gx, -gy, 1.0 + (gx * X.x() + gy * X.y()) / X.z());
  const double sigma =
      2.0 * model.inverse_depth_sigma(z) * z * z + kOffPixel * normal.head<2>().norm();
  Row row;
  row.J << normal, X.cross(normal);
  row.J /= sigma;
  row.r = (X.z() - z) / sigma;
  return row;
}

}  // namespace

double depth_agreement(const PointList& points,
                       const Matrix4& T_th,
                       const PinholeCamera& camera,
                       const SensedDepth& sensed) {
  int compared = 0;
  int agreeing = 0;
  visit_landings(points, T_th, camera, sensed, 1, [&](const Vector3& X, int, int, double z) {
    ++compared;
    if (std::abs(X.z() - z) <= sensed.max_difference * z) ++agreeing;
  });
  return compared < kMinPoints ? 1.0 : static_cast<double>(agreeing) / compared;
}

Vector6 depth_step(const PointList& points,
                   const Matrix4& T_th,
                   const PinholeCamera& camera,
                   const SensedDepth& sensed) {
  std::vector<Row> rows;
  rows.reserve(static_cast<std::size_t>(points.num_points()));
  const int stride = std::max(1, points.num_points() / kEnoughPoints);
  visit_landings(points, T_th, camera, sensed, stride,
                 [&](const Vector3& X, int u, int v, double z) {
                   double du = 0.0;
                   double dv = 0.0;
                   if (std::abs(X.z() - z) > sensed.max_difference * z) return;
                   if (slope_at(sensed, u, v, z, du, dv)) {
                     rows.push_back(row_of(X, z, du, dv, camera, sensed.model));
                   }
                 });
  Vector6 step = Vector6::Zero();
  if (static_cast<int>(rows.size()) < kMinPoints) return step;
  Vector6 prior = Vector6::Constant(1.0 / (kPriorSigma * kPriorSigma));
  prior.head<3>() *= points.mean_inverse_depth() * points.mean_inverse_depth();
  for (int i = 0; i < kSteps; ++i) {
    Matrix6 H = prior.asDiagonal();
    Vector6 g = Vector6::Zero();
    for (const Row& row : rows) {
      const double size = std::abs(row.r + row.J.dot(step));
      const double weight = size <= kHuber ? 1.0 : kHuber / size;
      H += weight * row.J * row.J.transpose();
      g += weight * row.r * row.J;
    }
    step = -H.ldlt().solve(g);
  }
  return step.allFinite() ? step : Vector6(Vector6::Zero());
}

}  // namespace raylign
