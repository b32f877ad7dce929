// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/views.h"
#include "raylign/solver/bundle_config.h"

namespace raylign::photometric {

/// What may move, once for all rounds: the config and its gauge, what the options refine, and the
/// brightness of the image that the others are measured by. Throws OptionsError for single
/// coordinates of a point.
PatchConstraints base_constraints(const Setting& setting,
                                  const PhotometricState& start,
                                  const BundleConfig& config);

/// Priors in units of the cost, which is the negative logarithm of a probability times `unit`
/// (grey²): see cost_unit.
void set_priors(const Setting& setting,
                const PhotometricState& start,
                double unit,
                PatchConstraints& constraints);

/// Cost per nat of a law: σ², of Student's t σ² ν / (ν + 1).
double cost_unit(const Loss& loss, double sigma);

/// Holds the points that are not in `active` or have no edge.
void hold_unused(const PatchScene& scene,
                 const std::vector<bool>& held,
                 PatchConstraints& constraints);

/// Holds the pose and the brightness of an image.
void hold_image(std::size_t i, PatchConstraints& constraints);

/// "first camera and the scale", … for people.
std::string describe_gauge(const Setting& setting, const BundleConfig& config);

}  // namespace raylign::photometric
