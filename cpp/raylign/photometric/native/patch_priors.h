// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/native/patch_kernels.h"

/// Priors on brightness, poses and points: what they cost and what they add to the normal
/// equations.
namespace raylign::native {

/// What priors look at; `PatchConstraints::point_priors` name places in `points`.
struct PriorState {
  const std::vector<PatchPose>& poses;
  const Rows<double, 2>& brightness;
  const std::vector<double>& points;  ///< (N, 3)
  bool inverse_depth;                 ///< the first coordinate alone
};

double prior_cost(const PatchConstraints& constraints, const PriorState& state);

/// Where they are added; see NormalArrays.
struct PriorTargets {
  int num_columns;  ///< C of an image
  const std::int64_t* block_starts;
  double* H;
  double* gradient;
  PointBlock* points;
};

void add_priors(const PatchConstraints& constraints,
                const PriorState& state,
                const PriorTargets& targets);

}  // namespace raylign::native
