// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/image/plane.h"

namespace raylign {

/// σ of the noise of single pixels: the median size of the answer to [1 −2 1]ᵀ [1 −2 1], which is
/// blind to whatever is quadratic along a row or a column (Immerkær, Fast Noise Variance
/// Estimation, CVIU 1996, with the median for the mean: edges and corners answer, too, but are
/// few). Noise that neighbours share, as after JPEG, is seen in part only. 0 for images below 3x3.
double estimate_pixel_noise(const Plane<float>& image);

}  // namespace raylign
