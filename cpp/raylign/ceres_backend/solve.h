// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/linearization.h"
#include "raylign/solver/summary.h"

namespace raylign::ceres_backend {

/// Solves through Ceres. Arguments validated by the caller (bundle/bundle_adjuster.h), which is the
/// front door; the contract is the same.
Summary solve(BundleScene& scene,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback);

/// Cost, gradient and sparse Jacobian at the current state.
Linearization linearize(const BundleScene& scene,
                        const BundleConfig& config,
                        const BundleOptions& options);

}  // namespace raylign::ceres_backend
