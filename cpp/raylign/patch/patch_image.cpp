// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/patch_image.h"

#include <algorithm>
#include <cmath>

namespace raylign {
namespace {

// Readable pixels around an image whose interpolation needs neighbours: two for a central
// difference one pixel outside, and one more for the cell of a position on the border.
constexpr int kBorder = 3;

}  // namespace

PatchImage::PatchImage(const ImagePyramid& pyramid,
                       SampleInterpolation interpolation,
                       PatchBorder border) {
  splines_.reserve(static_cast<std::size_t>(pyramid.num_levels()));
  padded_.reserve(static_cast<std::size_t>(pyramid.num_levels()));
  for (int level = 0; level < pyramid.num_levels(); ++level) {
    const PlaneView<float> image = pyramid.level(level).view();
    sizes_.push_back({image.width, image.height});
    if (interpolation == SampleInterpolation::CUBIC_BSPLINE) {
      add_spline(image);
    } else {
      add_padded(image, border);
    }
  }
}

void PatchImage::add_spline(const PlaneView<float>& image) {
  splines_.emplace_back(image);
  const PlaneView<float> c = splines_.back().coefficients();
  constexpr int kBefore = BSplineImage::kBefore;
  planes_.push_back({c.row(kBefore) + kBefore, c.stride, image.width - 1.0, image.height - 1.0});
}

void PatchImage::add_padded(const PlaneView<float>& image, PatchBorder border) {
  Plane<float> padded(image.width + 2 * kBorder, image.height + 2 * kBorder);
  const std::int64_t size = std::int64_t{image.width} * image.height;
  for (int v = -kBorder; v < image.height + kBorder; ++v) {
    for (int u = -kBorder; u < image.width + kBorder; ++u) {
      const int row = std::clamp(v, 0, image.height - 1);
      int at_u = std::clamp(u, 0, image.width - 1);
      int at_v = row;
      if (border == PatchBorder::WRAP) {
        const std::int64_t at =
            std::clamp<std::int64_t>(std::int64_t{v} * image.width + u, 0, size - 1);
        at_u = static_cast<int>(at % image.width);
        at_v = static_cast<int>(at / image.width);
      }
      padded.at(u + kBorder, v + kBorder) = image.at(at_u, at_v);
    }
  }
  padded_.push_back(std::move(padded));
  Plane<float>& kept = padded_.back();
  const bool wraps = border == PatchBorder::WRAP;
  const auto bound = [&](int n) { return wraps ? std::nextafter(double(n), 0.0) : n - 1.0; };
  planes_.push_back(
      {kept.row(kBorder) + kBorder, kept.width(), bound(image.width), bound(image.height)});
}

namespace {

double bilinear(const PatchPlane& plane, double u, double v, double& du, double& dv) {
  const int first_u = static_cast<int>(std::floor(u));
  const int first_v = static_cast<int>(std::floor(v));
  const double x = u - first_u;
  const double y = v - first_v;
  const float* upper = plane.origin + first_v * plane.stride + first_u;
  const float* lower = upper + plane.stride;
  const double top = upper[0] + x * (double(upper[1]) - upper[0]);
  const double bottom = lower[0] + x * (double(lower[1]) - lower[0]);
  du = (1.0 - y) * (double(upper[1]) - upper[0]) + y * (double(lower[1]) - lower[0]);
  dv = bottom - top;
  return top + y * dv;
}

Sample<double> central_difference(const PatchPlane& plane, double u, double v) {
  double unused_u = 0.0;
  double unused_v = 0.0;
  const auto value = [&](double at_u, double at_v) {
    return bilinear(plane, at_u, at_v, unused_u, unused_v);
  };
  // the exercise reads the cell of the first column (row) for the one before it, too
  const double left = u < 1.0 ? u : u - 1.0;
  const double up = v < 1.0 ? v : v - 1.0;
  return {value(u, v), 0.5 * (value(u + 1.0, v) - value(left, v)),
          0.5 * (value(u, v + 1.0) - value(u, up))};
}

Sample<double> spline(const PatchPlane& plane, double u, double v) {
  const int first_u = static_cast<int>(u);
  const int first_v = static_cast<int>(v);
  double wu[4], du[4], wv[4], dv[4];
  bspline_weights(u - first_u, wu, du);
  bspline_weights(v - first_v, wv, dv);
  Sample<double> sample = {0.0, 0.0, 0.0};
  for (int j = 0; j < 4; ++j) {
    const float* c = plane.origin + (first_v - 1 + j) * plane.stride + first_u - 1;
    const double value = wu[0] * c[0] + wu[1] * c[1] + wu[2] * c[2] + wu[3] * c[3];
    const double slope = du[0] * c[0] + du[1] * c[1] + du[2] * c[2] + du[3] * c[3];
    sample.value += wv[j] * value;
    sample.du += wv[j] * slope;
    sample.dv += dv[j] * value;
  }
  return sample;
}

}  // namespace

Sample<double> sample_patch_plane(const PatchPlane& plane,
                                  SampleInterpolation interpolation,
                                  double u,
                                  double v) {
  switch (interpolation) {
    case SampleInterpolation::CUBIC_BSPLINE:
      return spline(plane, u, v);
    case SampleInterpolation::CENTRAL_DIFFERENCE:
      return central_difference(plane, u, v);
    case SampleInterpolation::BILINEAR:
      break;
  }
  Sample<double> sample;
  sample.value = bilinear(plane, u, v, sample.du, sample.dv);
  return sample;
}

}  // namespace raylign
