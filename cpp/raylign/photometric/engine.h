// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/summary.h"

namespace raylign::photometric {

/// Minimises a scene with the engine asked for.
Summary solve_scene(PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options,
                    Backend backend,
                    const IterationCallback& callback,
                    const InterruptCheck& interrupted);

}  // namespace raylign::photometric
