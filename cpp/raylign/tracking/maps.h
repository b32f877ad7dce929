// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/tracking/point_pass.h"
#include "raylign/tracking/result.h"

namespace raylign::tracking {

/// What the points of a level look like at a state, pixel by pixel of the keyframe.
AlignmentMaps make_maps(const Keyframe& keyframe,
                        const Frame& target,
                        int level,
                        const PassSettings& settings);

}  // namespace raylign::tracking
