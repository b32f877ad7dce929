// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/image/bspline.h"
#include "raylign/image/plane.h"

namespace raylign {

/// How sample_points reads between pixels.
enum class SampleInterpolation {
  BILINEAR,            ///< bilinear value and its exact gradient, which jumps at pixels
  CENTRAL_DIFFERENCE,  ///< bilinear value, bilinearly interpolated central differences
  CUBIC_BSPLINE,       ///< BSplineImage: smooth, value and gradient agree
};

/// n points, in C order. Where `valid` is 0 the rest is NaN: outside of the image, or a pixel that
/// the sample needs is not finite.
struct SamplePoints {
  std::int64_t n;
  const double* uv;   ///< (n, 2) px
  double* values;     ///< (n,)
  double* gradients;  ///< (n, 2) d value / d(u, v), per px
  bool* valid;        ///< (n,)
};

void sample_points(const PlaneView<float>& image,
                   SampleInterpolation interpolation,
                   const SamplePoints& points);
void sample_points(const BSplineImage& image, const SamplePoints& points);

}  // namespace raylign
