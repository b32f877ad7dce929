// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "raylign/image/sample_points.h"

namespace raylign {

/// What smoothing and interpolation make of independent noise of variance one in the pixels of an
/// image: variances of a value and of a slope between the pixels. Both are sums over pixels with
/// known weights, products of one along u and one along v; a variance is the sum of their squares.
class SampledNoise {
 public:
  /// @param presmooth  σ of the Gaussian that the image is smoothed with before, px; 0: none
  explicit SampledNoise(SampleInterpolation interpolation, double presmooth = 0.0);

  /// Variance of I at a position, px: what counts is its fraction.
  double value(double u, double v) const;
  /// Mean over the fractions.
  double mean_value() const { return mean_value_ * mean_value_; }
  /// Of ∂I/∂u, which is that of ∂I/∂v; mean over the fractions.
  double mean_gradient() const { return mean_slope_ * mean_value_; }

 private:
  static constexpr int kFractions = 64;

  std::array<double, kFractions + 1> values_{};  // along one axis, at k / kFractions
  double mean_value_ = 0.0;
  double mean_slope_ = 0.0;
};

/// Weights of a Gaussian at whole numbers from −⌈4 σ⌉ to ⌈4 σ⌉, of sum one; σ > 0.
std::vector<double> gaussian_kernel(double sigma);

}  // namespace raylign
