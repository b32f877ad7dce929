// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/solver/summary.h"

namespace raylign::native {

/// validate_patch_solve, and an OptionsError when the images' dense system would be too large.
void check_solvable(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options);

/// Minimises the scene's cost with raylign's own engine: gradient tensors instead of 16-row
/// Jacobians, points eliminated, the images' system dense. On return `scene` holds the best state
/// found, the start bit by bit when no step was accepted. Same bits for any number of threads.
/// Throws OptionsError, ShapeError; numerical trouble is Termination::FAILURE.
/// @param interrupted  asked before every linear solve
Summary solve_patches(PatchScene& scene,
                      const PatchConstraints& constraints,
                      const PatchSolveOptions& options,
                      const IterationCallback& callback = nullptr,
                      const InterruptCheck& interrupted = nullptr);

/// The largest entry of the diagonal of H, images' free columns and points: what the damping of the
/// original exercise starts from. Throws as solve_patches.
double max_diagonal(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options);

}  // namespace raylign::native
