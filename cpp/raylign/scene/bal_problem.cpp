// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_problem.h"

#include "raylign/scene/problem_checks.h"

namespace raylign {

void BalProblem::validate() const {
  check_count("BalProblem.cameras", num_cameras());
  check_count("BalProblem.points", num_points());
  check_rows("BalProblem.camera_index", camera_index.rows(), "observations", num_observations());
  check_rows("BalProblem.point_index", point_index.rows(), "observations", num_observations());
  if (colors.rows() != 0) check_rows("BalProblem.colors", colors.rows(), "points", num_points());
  check_index("BalProblem.camera_index", camera_index, num_cameras());
  check_index("BalProblem.point_index", point_index, num_points());
}

bool operator==(const BalProblem& a, const BalProblem& b) {
  return same_bits(a.camera_index, b.camera_index) && same_bits(a.point_index, b.point_index) &&
         same_bits(a.cameras, b.cameras) && same_bits(a.points, b.points) &&
         same_bits(a.observations, b.observations) && same_bits(a.colors, b.colors);
}

bool operator!=(const BalProblem& a, const BalProblem& b) { return !(a == b); }

}  // namespace raylign
