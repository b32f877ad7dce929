// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/image/plane.h"

namespace raylign {

/// Intensity and gradient of a pixel side by side: one bilinear fetch of four cells gives all.
struct alignas(16) GradientCell {
  float value;
  float du;  ///< (I(u + 1, v) - I(u - 1, v)) / 2, grey levels per px
  float dv;
  float zero;  ///< always 0: a whole cell can be summed
};

using GradientImage = Plane<GradientCell>;

/// Central differences of every pixel, one-sided at the border (numpy.gradient's rule); 0 along a
/// side of one pixel. Reuses the memory of `cells`.
void make_gradient_image(const PlaneView<float>& image, GradientImage& cells);

/// The largest |gradient| within 3x3 pixels, cut off at the border; not finite gradients count as
/// 0. A pixel is worth using for depth or tracking when this is large.
void make_max_gradient(const PlaneView<GradientCell>& cells, Plane<float>& maximum);

}  // namespace raylign
