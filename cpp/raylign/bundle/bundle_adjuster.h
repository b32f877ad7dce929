// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/scene/bal_problem.h"
#include "raylign/scene/bundle_problem.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/linearization.h"
#include "raylign/solver/summary.h"

namespace raylign {

/// Minimises ½ Σ ρ(‖π(R_cw X + t_cw) − u‖²) over poses, intrinsics and points (Triggs et al. 2000).
///
/// `problem` is the one argument that changes: on return it holds the best state found, which is
/// the start, bit by bit, when no step was accepted. Throws OptionsError, ShapeError; numerical
/// trouble is no exception but Termination::FAILURE with a message. `interrupted` is asked by
/// backend NATIVE between two iterations of conjugate gradients; Ceres has no such place.
Summary adjust(BalProblem& problem,
               const BundleConfig& config,
               const BundleOptions& options,
               const IterationCallback& callback = nullptr,
               const InterruptCheck& interrupted = nullptr);
Summary adjust(BundleProblem& problem,
               const BundleConfig& config,
               const BundleOptions& options,
               const IterationCallback& callback = nullptr,
               const InterruptCheck& interrupted = nullptr);

/// The same problem linearised at its current state: cost, gradient, sparse Jacobian (see
/// Linearization). Throws Error when a residual is not finite there, and whatever `adjust` throws.
Linearization linearize(const BalProblem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options);
Linearization linearize(const BundleProblem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options);

}  // namespace raylign
