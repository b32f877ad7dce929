// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/parametrization/start_check.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign {

std::string describe_invalid_start(const BundleScene& scene, const Loss& loss) {
  const auto residuals = reprojection_residuals(scene);
  double cost = 0.0;
  for (std::int64_t i = 0; i < scene.num_observations(); ++i) {
    cost += loss.evaluate(residuals.row(i).squaredNorm()).rho;
    if (std::isfinite(cost)) continue;
    return "the start is invalid: observation " + std::to_string(i) + " (camera " +
           std::to_string(scene.camera_index[i]) + ", point " +
           std::to_string(scene.point_index[i]) +
           ") has no finite reprojection error; its depth is " + format_double(depths(scene)[i]);
  }
  return "";
}

}  // namespace raylign
