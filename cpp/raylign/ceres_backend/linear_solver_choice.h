// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/options.h"

namespace raylign::ceres_backend {

struct LinearSolverChoice {
  LinearSolverType type;
  std::string reason;
};

/// What AUTO means for this problem; anything else is taken as it is.
LinearSolverChoice choose_linear_solver(LinearSolverType requested,
                                        std::int64_t num_cameras,
                                        bool has_free_point);

/// Throws OptionsError for a preconditioner that Ceres does not have, alone or on an explicit S.
void check_preconditioner(const LinearSolverOptions& options);

/// Throws OptionsError when Ceres could not hold the problem: its sizes are `int`, its dense
/// matrices are allocated whole, and it checks neither.
void check_ceres_limits(const BundleScene& scene, LinearSolverType type, bool has_free_point);

}  // namespace raylign::ceres_backend
