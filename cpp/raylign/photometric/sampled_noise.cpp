// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/sampled_noise.h"

#include <cmath>
#include <cstddef>

#include "raylign/image/bspline.h"

namespace raylign {
namespace {

using Weights = std::vector<double>;  // of consecutive pixels

Weights convolved(const Weights& a, const Weights& b) {
  Weights out(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < b.size(); ++k) out[i + k] += a[i] * b[k];
  }
  return out;
}

double energy(const Weights& weights) {
  double sum = 0.0;
  for (const double w : weights) sum += w * w;
  return sum;
}

// From grey values to the coefficients of the cubic B-spline: √3 z^|k|, z = √3 − 2 (Unser,
// IEEE Signal Processing Magazine 1999, box 2).
Weights spline_prefilter() {
  constexpr int kReach = 16;  // z^16 < 1e-9
  const double z = std::sqrt(3.0) - 2.0;
  Weights kernel;
  for (int k = -kReach; k <= kReach; ++k)
    kernel.push_back(std::sqrt(3.0) * std::pow(z, std::abs(k)));
  return kernel;
}

struct AxisWeights {
  Weights value, slope;
};

// Of the samples (coefficients) around a position whose fraction is f.
AxisWeights taps(SampleInterpolation interpolation, double f) {
  switch (interpolation) {
    case SampleInterpolation::CUBIC_BSPLINE: {
      double w[4], d[4];
      bspline_weights(f, w, d);
      return {Weights(w, w + 4), Weights(d, d + 4)};
    }
    case SampleInterpolation::CENTRAL_DIFFERENCE:
      return {{1.0 - f, f}, {-0.5 * (1.0 - f), -0.5 * f, 0.5 * (1.0 - f), 0.5 * f}};
    case SampleInterpolation::BILINEAR:
      break;
  }
  return {{1.0 - f, f}, {-1.0, 1.0}};
}

}  // namespace

std::vector<double> gaussian_kernel(double sigma) {
  constexpr double kReach = 4.0;
  const int radius = static_cast<int>(std::ceil(kReach * sigma));
  std::vector<double> kernel;
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    kernel.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    sum += kernel.back();
  }
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

SampledNoise::SampledNoise(SampleInterpolation interpolation, double presmooth) {
  Weights before = {1.0};
  if (presmooth > 0.0) before = gaussian_kernel(presmooth);
  if (interpolation == SampleInterpolation::CUBIC_BSPLINE) {
    before = convolved(before, spline_prefilter());
  }
  for (int k = 0; k <= kFractions; ++k) {
    const AxisWeights at = taps(interpolation, double(k) / kFractions);
    values_[static_cast<std::size_t>(k)] = energy(convolved(before, at.value));
    const double share = (k == 0 || k == kFractions ? 0.5 : 1.0) / kFractions;
    mean_value_ += share * values_[static_cast<std::size_t>(k)];
    mean_slope_ += share * energy(convolved(before, at.slope));
  }
}

double SampledNoise::value(double u, double v) const {
  const auto along = [&](double x) {
    return values_[static_cast<std::size_t>(std::lround((x - std::floor(x)) * kFractions))];
  };
  return along(u) * along(v);
}

}  // namespace raylign
