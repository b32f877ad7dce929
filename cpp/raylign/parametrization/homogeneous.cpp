// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/parametrization/homogeneous.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace raylign {

Vector4 HomogeneousFrame::from_world(const Vector3& X) const {
  return Vector3((X - center) / scale).homogeneous().stableNormalized();
}

Vector3 HomogeneousFrame::to_world(const Vector4& x) const {
  return center + scale / bounded_weight(x[3]) * x.head<3>();
}

double HomogeneousFrame::bounded_weight(double w) {
  constexpr double kSmallest = 1e-12;
  return std::abs(w) < kSmallest ? std::copysign(kSmallest, w) : w;
}

HomogeneousFrame homogeneous_frame(const BundleScene& scene) {
  HomogeneousFrame frame;
  if (scene.num_cameras() == 0) return frame;
  const Rows<double, 3> centers = camera_centers(scene);
  frame.center = centers.colwise().mean().transpose();
  double extent = (centers.rowwise() - frame.center.transpose()).norm() /
                  std::sqrt(static_cast<double>(scene.num_cameras()));
  if (!(extent > 1e-9 * frame.center.norm()) && scene.num_points() > 0) {
    Eigen::VectorXd distances =
        (scene.points.rowwise() - frame.center.transpose()).rowwise().norm();
    auto* middle = distances.data() + distances.size() / 2;
    std::nth_element(distances.data(), middle, distances.data() + distances.size());
    extent = *middle;
  }
  if (extent > 0.0 && std::isfinite(extent)) frame.scale = extent;
  if (!frame.center.allFinite()) frame.center.setZero();
  return frame;
}

// Golub and Van Loan, Matrix Computations, algorithm 5.1.1 with the last entry as pivot.
SphereTangent::SphereTangent(const Vector4& x)
    : v_(x[0], x[1], x[2], 1.0), beta_(x[3] < 0.0 ? 2.0 : 0.0) {
  const double sigma = x.head<3>().squaredNorm();
  if (sigma <= std::numeric_limits<double>::epsilon()) return;
  const double mu = std::sqrt(x[3] * x[3] + sigma);
  const double pivot = x[3] <= 0.0 ? x[3] - mu : -sigma / (x[3] + mu);
  beta_ = 2.0 * pivot * pivot / (sigma + pivot * pivot);
  v_.head<3>() /= pivot;
}

RowMajor<4, 3> SphereTangent::basis() const {
  RowMajor<4, 3> B = -0.5 * beta_ * v_ * v_.head<3>().transpose();
  B.topRows<3>().diagonal().array() += 0.5;
  return B;
}

Vector4 SphereTangent::plus(const Vector3& delta) const {
  const double half = 0.5 * delta.norm();
  const double sinc = half > 0.0 ? std::sin(half) / half : 1.0;
  Vector4 y;
  y << 0.5 * sinc * delta, std::cos(half);
  return y - v_ * (beta_ * v_.dot(y));
}

}  // namespace raylign
