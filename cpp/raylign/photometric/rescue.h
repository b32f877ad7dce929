// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/photometric/refinement.h"

namespace raylign::photometric {

/// Looks for images that a refinement has lost while it has put most others right: each is aligned
/// alone to the points that the right images agree on, from the pose it started with, the one it
/// ended with, and both turned by about a tenth of the field of view to all sides, on all levels.
/// Unlike in a round, a view that shows something else is not left out: here it is the view that is
/// wrong. Points whose patches come from an image that is found start again from their depth at the
/// start.
/// @param is_lost  (M,) of the images; those that are held are not looked for
/// @return the images that were found: `state` has them at their places
std::vector<std::int32_t> find_lost_images(const Setting& setting,
                                           const PatchConstraints& base,
                                           const PhotometricState& start,
                                           const std::vector<bool>& is_lost,
                                           Progress& progress,
                                           PhotometricState& state);

}  // namespace raylign::photometric
