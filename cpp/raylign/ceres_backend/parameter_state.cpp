// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/parameter_state.h"

#include <algorithm>

#include "raylign/scene/bal_transform.h"

namespace raylign::ceres_backend {

HomogeneousFrame homogeneous_frame(const BalProblem& problem) {
  HomogeneousFrame frame;
  if (problem.num_cameras() == 0) return frame;
  const Rows<double, 3> centers = camera_centers(problem);
  frame.center = centers.colwise().mean().transpose();
  double extent = (centers.rowwise() - frame.center.transpose()).norm() /
                  std::sqrt(static_cast<double>(problem.num_cameras()));
  if (!(extent > 1e-9 * frame.center.norm()) && problem.num_points() > 0) {
    Eigen::VectorXd distances =
        (problem.points.rowwise() - frame.center.transpose()).rowwise().norm();
    auto* middle = distances.data() + distances.size() / 2;
    std::nth_element(distances.data(), middle, distances.data() + distances.size());
    extent = *middle;
  }
  if (extent > 0.0 && std::isfinite(extent)) frame.scale = extent;
  if (!frame.center.allFinite()) frame.center.setZero();
  return frame;
}

}  // namespace raylign::ceres_backend
