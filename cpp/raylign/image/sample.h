// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "raylign/image/gradient.h"
#include "raylign/image/plane.h"

namespace raylign {

/// What a sampler reads at (u, v).
template <typename Scalar>
struct Sample {
  Scalar value;
  Scalar du;  ///< d value / du, per px
  Scalar dv;
};

namespace detail {

// The cell of a coordinate in [0, size - 1] and the position in it. The last pixel belongs to the
// cell before it; an image of one pixel has a cell without extent.
template <typename Scalar>
struct Cell {
  Cell(Scalar x, int size) {
    first = std::max(std::min(static_cast<int>(x), size - 2), 0);
    second = std::min(first + 1, size - 1);
    fraction = x - Scalar(first);
  }

  int first;
  int second;
  Scalar fraction;
};

}  // namespace detail

/// Bilinear value and the exact gradient of the interpolant, which jumps at pixels (there: that of
/// the cell to the right and below, at the last pixel of the cell before). False, with `sample`
/// unspecified, unless image.contains(u, v). Not finite when one of the four pixels is not, even at
/// weight 0.
template <typename Scalar>
bool sample_bilinear(const PlaneView<float>& image, Scalar u, Scalar v, Sample<Scalar>& sample) {
  if (!image.contains(u, v)) return false;
  const detail::Cell<Scalar> x(u, image.width);
  const detail::Cell<Scalar> y(v, image.height);
  const float* upper = image.row(y.first);
  const float* lower = image.row(y.second);
  const Scalar top = upper[x.first];
  const Scalar bottom = lower[x.first];
  const Scalar top_step = upper[x.second] - top;
  const Scalar bottom_step = lower[x.second] - bottom;
  const Scalar top_value = top + x.fraction * top_step;
  sample.dv = bottom + x.fraction * bottom_step - top_value;
  sample.value = top_value + y.fraction * sample.dv;
  sample.du = top_step + y.fraction * (bottom_step - top_step);
  return true;
}

/// Bilinear value, and the bilinearly interpolated central differences: smoother than the exact
/// gradient of the value and with a wider basin, but not its derivative. Domain as above.
template <typename Scalar>
bool sample_bilinear(const PlaneView<GradientCell>& image,
                     Scalar u,
                     Scalar v,
                     Sample<Scalar>& sample) {
  if (!image.contains(u, v)) return false;
  const detail::Cell<Scalar> x(u, image.width);
  const detail::Cell<Scalar> y(v, image.height);
  const GradientCell* upper = image.row(y.first);
  const GradientCell* lower = image.row(y.second);
  const Scalar one(1);
  const Scalar w00 = (one - x.fraction) * (one - y.fraction);
  const Scalar w10 = x.fraction * (one - y.fraction);
  const Scalar w01 = (one - x.fraction) * y.fraction;
  const Scalar w11 = x.fraction * y.fraction;
  const GradientCell& a = upper[x.first];
  const GradientCell& b = upper[x.second];
  const GradientCell& c = lower[x.first];
  const GradientCell& d = lower[x.second];
  sample.value = w00 * a.value + w10 * b.value + w01 * c.value + w11 * d.value;
  sample.du = w00 * a.du + w10 * b.du + w01 * c.du + w11 * d.du;
  sample.dv = w00 * a.dv + w10 * b.dv + w01 * c.dv + w11 * d.dv;
  return true;
}

}  // namespace raylign
