// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/options.h"
#include "raylign/photometric/problem.h"
#include "raylign/solver/bundle_config.h"

namespace raylign {

/// What an engine solves: everything discrete decided.
struct FrozenProblem {
  PatchScene scene;
  PatchConstraints constraints;
  PatchSolveOptions options;
};

/// What `adjust` would solve on level 0 if it found itself at the problem's own state: views, warps
/// and law as they are there, all points. At the truth of a rendered scene: what its Cramér-Rao
/// bound is the bound of. Throws as `adjust`.
FrozenProblem freeze(const PhotometricProblem& problem,
                     const BundleConfig& config,
                     const PhotometricOptions& options);

}  // namespace raylign
