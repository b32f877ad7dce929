// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/scene/bal_problem.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/summary.h"

namespace raylign::native {

/// Solves with raylign's own engine (docs/theory/native-engine.md). Arguments validated by the
/// caller (bundle/bundle_adjuster.h), which is the front door; the contract is the same. Throws
/// OptionsError for what the engine does not do: points other than XYZ, DENSE_NORMAL_CHOLESKY, the
/// preconditioners of Ceres alone.
Summary solve(BalProblem& problem,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback);

}  // namespace raylign::native
