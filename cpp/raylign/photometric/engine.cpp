// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/engine.h"

#include "raylign/ceres_backend/patch_solver.h"
#include "raylign/photometric/native/solve.h"

namespace raylign::photometric {

Summary solve_scene(PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options,
                    Backend backend,
                    const IterationCallback& callback,
                    const InterruptCheck& interrupted) {
  if (scene.num_edges() == 0) return nothing_to_adjust(to_string(backend));
  if (backend == Backend::NATIVE) {
    return native::solve_patches(scene, constraints, options, callback, interrupted);
  }
  return ceres_backend::solve_patches(scene, constraints, options, callback);
}

}  // namespace raylign::photometric
