// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bundle_problem.h"

#include <string>

#include "raylign/base/error.h"
#include "raylign/scene/problem_checks.h"

namespace raylign {
Matrix4 BundleProblem::pose(std::int64_t i) const {
  return Eigen::Map<const RowMajor<4, 4>>(T_cw.row(i).data());
}

void BundleProblem::validate() const {
  check_count("BundleProblem.T_cw", num_cameras());
  check_count("BundleProblem.points", num_points());
  check_rows("BundleProblem.intrinsics", intrinsics.rows(), "T_cw", num_cameras());
  if (intrinsics.cols() != num_params(camera_model)) {
    throw ShapeError("BundleProblem.intrinsics has " + std::to_string(intrinsics.cols()) +
                     " columns, but the " + to_string(camera_model) + " model has " +
                     std::to_string(num_params(camera_model)) + " parameters");
  }
  check_rows("BundleProblem.camera_index", camera_index.rows(), "observations", num_observations());
  check_rows("BundleProblem.point_index", point_index.rows(), "observations", num_observations());
  if (colors.rows() != 0) check_rows("BundleProblem.colors", colors.rows(), "points", num_points());
  check_index("BundleProblem.camera_index", camera_index, num_cameras());
  check_index("BundleProblem.point_index", point_index, num_points());
  for (std::int64_t i = 0; i < num_cameras(); ++i) {
    check_rigid("BundleProblem.T_cw[" + std::to_string(i) + "]", pose(i));
  }
}

bool operator==(const BundleProblem& a, const BundleProblem& b) {
  return a.camera_model == b.camera_model && same_bits(a.camera_index, b.camera_index) &&
         same_bits(a.point_index, b.point_index) && same_bits(a.T_cw, b.T_cw) &&
         same_bits(a.intrinsics, b.intrinsics) && same_bits(a.points, b.points) &&
         same_bits(a.observations, b.observations) && same_bits(a.colors, b.colors);
}

bool operator!=(const BundleProblem& a, const BundleProblem& b) { return !(a == b); }

}  // namespace raylign
