// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// Brightness (M, 2) to start from: for each image a, b such that the grey values it shows around
/// the points have the quantiles of the patches there. Quantiles do not ask that the geometry is
/// right, only that image and patches show about the same. Images that share no point with others
/// keep a = b = 0.
Rows<double, 2> estimate_brightness(const Setting& setting,
                                    const PhotometricState& state,
                                    int level);

}  // namespace raylign::photometric
