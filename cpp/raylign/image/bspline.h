// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "raylign/image/plane.h"
#include "raylign/image/sample.h"

namespace raylign {

/// Weights of the four coefficients around a fraction f in [0, 1] of a pixel, and their
/// derivatives: the uniform cubic B-spline.
template <typename Scalar>
void bspline_weights(Scalar f, Scalar* weights, Scalar* derivatives) {
  const Scalar g = Scalar(1) - f;
  weights[0] = g * g * g / Scalar(6);
  weights[1] = Scalar(2) / Scalar(3) - f * f * (Scalar(1) - f / Scalar(2));
  weights[2] = Scalar(2) / Scalar(3) - g * g * (Scalar(1) - g / Scalar(2));
  weights[3] = f * f * f / Scalar(6);
  derivatives[0] = -g * g / Scalar(2);
  derivatives[1] = f * (Scalar(1.5) * f - Scalar(2));
  derivatives[2] = -g * (Scalar(1.5) * g - Scalar(2));
  derivatives[3] = f * f / Scalar(2);
}

/// The cubic spline through all pixels, mirrored at the border pixels: twice continuously
/// differentiable, so that value and gradient agree everywhere (Unser, IEEE Signal Processing
/// Magazine 16(6), 1999).
class BSplineImage {
 public:
  /// Coefficients stored before the first and behind the last pixel.
  static constexpr int kBefore = 1;
  static constexpr int kBehind = 2;

  BSplineImage() = default;
  explicit BSplineImage(const PlaneView<float>& image) { assign(image); }

  /// Solves for the coefficients; reuses memory. A pixel that is not finite has no data: the four
  /// by four pixels of a sample must not hold one, other samples do not see it. Throws ShapeError
  /// for an empty image.
  void assign(const PlaneView<float>& image);

  int width() const { return width_; }
  int height() const { return height_; }
  /// (height + 3) rows of width + 3 values: the coefficient of pixel (u, v) is at (u + 1, v + 1),
  /// and the four by four of a sample start at (floor(u), floor(v)), without a test for the border.
  PlaneView<float> coefficients() const {
    return {coefficients_.data(), width_ + kBefore + kBehind, height_ + kBefore + kBehind,
            coefficients_.width()};
  }

  /// Value and exact gradient; false, with `sample` unspecified, unless 0 <= u <= width - 1 and
  /// 0 <= v <= height - 1.
  template <typename Scalar>
  bool sample(Scalar u, Scalar v, Sample<Scalar>& sample) const;

 private:
  int width_ = 0;
  int height_ = 0;
  Plane<float> coefficients_;
  Plane<float> scratch_;
};

template <typename Scalar>
bool BSplineImage::sample(Scalar u, Scalar v, Sample<Scalar>& sample) const {
  if (!PlaneView<float>{nullptr, width_, height_, 0}.contains(u, v)) return false;
  const int first_u = static_cast<int>(u);
  const int first_v = static_cast<int>(v);
  Scalar wu[4], du[4], wv[4], dv[4];
  bspline_weights(u - Scalar(first_u), wu, du);
  bspline_weights(v - Scalar(first_v), wv, dv);
  sample = {Scalar(0), Scalar(0), Scalar(0)};
  for (int j = 0; j < 4; ++j) {
    const float* c = coefficients_.row(first_v + j) + first_u;
    const Scalar value = wu[0] * c[0] + wu[1] * c[1] + wu[2] * c[2] + wu[3] * c[3];
    const Scalar slope = du[0] * c[0] + du[1] * c[1] + du[2] * c[2] + du[3] * c[3];
    sample.value += wv[j] * value;
    sample.du += wv[j] * slope;
    sample.dv += dv[j] * value;
  }
  return true;
}

}  // namespace raylign
