// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/solver/summary.h"

namespace raylign::ceres_backend {

/// Minimises the scene's cost through Ceres, with hand-written Jacobians: the reference of the
/// native engine. On return `scene` holds the best state found, the start bit by bit when no step
/// was accepted; so it does when the callback throws. Throws OptionsError, ShapeError; numerical
/// trouble is Termination::FAILURE.
Summary solve_patches(PatchScene& scene,
                      const PatchConstraints& constraints,
                      const PatchSolveOptions& options,
                      const IterationCallback& callback = nullptr);

}  // namespace raylign::ceres_backend
