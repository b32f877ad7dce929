// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/summary.h"

namespace raylign::native {

/// What of the call the engine does not have, in words that name a way out; empty: it has all.
/// Inverse-depth points, more than three free intrinsics of a camera, DENSE_NORMAL_CHOLESKY, the
/// preconditioners of Ceres alone.
std::string missing_feature(const BundleScene& scene,
                            const BundleConfig& config,
                            const BundleOptions& options);

/// Solves with raylign's own engine (docs/theory/native-engine.md). Arguments validated by the
/// caller (bundle/bundle_adjuster.h), which is the front door; the contract is the same. Throws
/// OptionsError for a missing feature.
Summary solve(BundleScene& scene,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback,
              const InterruptCheck& interrupted);

}  // namespace raylign::native
