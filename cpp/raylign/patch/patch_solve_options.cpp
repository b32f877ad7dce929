// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/patch_solve_options.h"

#include <cmath>
#include <string>

#include "raylign/base/error.h"
#include "raylign/patch/patch_scene.h"

namespace raylign {
namespace {

void require_rows(std::int64_t rows, std::int64_t expected, const char* what) {
  if (rows == expected) return;
  throw ShapeError(std::string("PatchConstraints.") + what + " must have " +
                   std::to_string(expected) + " rows, got " + std::to_string(rows));
}

void require_index(std::int64_t index, std::int64_t count, const char* what) {
  if (index >= 0 && index < count) return;
  throw ShapeError(std::string("PatchConstraints.") + what + " must be in [0, " +
                   std::to_string(count) + "), got " + std::to_string(index));
}

void require_finite(bool ok, const char* what) {
  if (!ok) throw OptionsError(std::string("PatchConstraints.") + what + " must be finite");
}

}  // namespace

void PatchSolveOptions::validate() const {
  loss.validate();
  lm.validate();
  require_option(max_leaving_share >= 0.0 && max_leaving_share <= 1.0,
                 "PatchSolveOptions.max_leaving_share", "in [0, 1]", max_leaving_share);
}

void validate_patch_solve(const PatchScene& scene,
                          const PatchConstraints& constraints,
                          const PatchSolveOptions& options) {
  options.validate();
  scene.validate();
  const std::int64_t M = scene.num_images();
  const std::int64_t N = scene.num_points();
  require_rows(static_cast<std::int64_t>(constraints.poses.size()), M, "poses");
  require_rows(static_cast<std::int64_t>(constraints.brightness.size()), M, "brightness");
  require_rows(static_cast<std::int64_t>(constraints.intrinsics.size()), scene.intrinsics.rows(),
               "intrinsics");
  if (!constraints.points.empty()) {
    require_rows(static_cast<std::int64_t>(constraints.points.size()), N, "points");
  }
  for (const double weight : {constraints.weight_a, constraints.weight_b}) {
    require_option(std::isfinite(weight) && weight >= 0.0, "PatchConstraints.weight_a, weight_b",
                   "finite and >= 0", weight);
  }
  for (const PosePrior& prior : constraints.pose_priors) {
    require_index(prior.image, M, "pose_priors.image");
    require_finite(prior.T_cw.allFinite() && prior.information.allFinite(), "pose_priors");
  }
  for (const PatchPointPrior& prior : constraints.point_priors) {
    require_index(prior.point, N, "point_priors.point");
    require_finite(prior.value.allFinite() && prior.information.allFinite(), "point_priors");
  }
}

}  // namespace raylign
