// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/sample_points.h"

#include <cmath>
#include <limits>

#include "raylign/image/gradient.h"
#include "raylign/image/sample.h"

namespace raylign {
namespace {

template <typename Sampler>
void for_each_point(const Sampler& sampler, const SamplePoints& points) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (std::int64_t i = 0; i < points.n; ++i) {
    Sample<double> sample{};
    const bool is_inside = sampler(points.uv[2 * i], points.uv[2 * i + 1], sample);
    const bool is_valid = is_inside && std::isfinite(sample.value) && std::isfinite(sample.du) &&
                          std::isfinite(sample.dv);
    points.valid[i] = is_valid;
    points.values[i] = is_valid ? sample.value : kNan;
    points.gradients[2 * i] = is_valid ? sample.du : kNan;
    points.gradients[2 * i + 1] = is_valid ? sample.dv : kNan;
  }
}

template <typename T>
void sample_bilinear_points(const PlaneView<T>& image, const SamplePoints& points) {
  for_each_point(
      [&](double u, double v, Sample<double>& s) { return sample_bilinear(image, u, v, s); },
      points);
}

}  // namespace

void sample_points(const BSplineImage& image, const SamplePoints& points) {
  for_each_point([&](double u, double v, Sample<double>& s) { return image.sample(u, v, s); },
                 points);
}

void sample_points(const PlaneView<float>& image,
                   SampleInterpolation interpolation,
                   const SamplePoints& points) {
  switch (interpolation) {
    case SampleInterpolation::BILINEAR:
      return sample_bilinear_points(image, points);
    case SampleInterpolation::CENTRAL_DIFFERENCE: {
      GradientImage cells;
      make_gradient_image(image, cells);
      return sample_bilinear_points(cells.view(), points);
    }
    case SampleInterpolation::CUBIC_BSPLINE:
      return sample_points(BSplineImage(image), points);
  }
}

}  // namespace raylign
