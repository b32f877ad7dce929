// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// Sets edges that are OK to OCCLUDED where another point's patch stands in front: nearer by more
/// than options.visibility.occlusion at the same place of the image. A patch whose normal is known
/// covers as the plane that it is, any other at the depth of its point.
/// @param cell  px: patches closer together than this are in each other's way
void mark_occluded(const Setting& setting,
                   const PhotometricState& state,
                   double cell,
                   Views& views);

}  // namespace raylign::photometric
