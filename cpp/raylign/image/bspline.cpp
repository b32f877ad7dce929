// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/bspline.h"

#include <cmath>
#include <limits>

#include "raylign/image/kernels.h"

namespace raylign {
namespace {

constexpr int kLanes = image_kernels::kFilterLanes;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Pixel x of a row or column of `size`, mirrored at both end pixels.
int mirror(int x, int size) {
  if (size == 1) return 0;
  const int period = 2 * (size - 1);
  const int wrapped = ((x % period) + period) % period;
  return wrapped < size ? wrapped : period - wrapped;
}

// Rows [begin, begin + kLanes) of the image, one per lane. A pixel without data takes the value of
// the last one that has data in its row: any finite value would do. Returns whether all are finite.
bool load_rows(const PlaneView<float>& image, int begin, float* lanes) {
  bool all_finite = true;
  for (int lane = 0; lane < kLanes; ++lane) {
    const float* row = image.row(std::min(begin + lane, image.height - 1));
    float last = 0.0F;
    for (int u = 0; u < image.width; ++u) {
      if (std::isfinite(row[u])) {
        last = row[u];
      } else {
        all_finite = false;
      }
      lanes[u * kLanes + lane] = last;
    }
  }
  return all_finite;
}

void erase_coefficients_without_data(const PlaneView<float>& image, Plane<float>& coefficients) {
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      if (!std::isfinite(image.at(u, v))) {
        coefficients.at(u + BSplineImage::kBefore, v + BSplineImage::kBefore) = kNan;
      }
    }
  }
}

void mirror_borders(int width, int height, Plane<float>& coefficients) {
  constexpr int kBefore = BSplineImage::kBefore;
  for (int v = 0; v < height; ++v) {
    float* row = coefficients.row(v + kBefore) + kBefore;
    for (const int u : {-1, width, width + 1}) row[u] = row[mirror(u, width)];
  }
  for (const int v : {-1, height, height + 1}) {
    const float* source = coefficients.row(mirror(v, height) + kBefore);
    std::copy(source, source + coefficients.width(), coefficients.row(v + kBefore));
  }
}

}  // namespace

void BSplineImage::assign(const PlaneView<float>& image) {
  if (image.empty()) throw ShapeError("image must have at least one pixel");
  width_ = image.width;
  height_ = image.height;
  const int used = width_ + kBefore + kBehind;
  coefficients_.resize((used + kLanes - 1) / kLanes * kLanes, height_ + kBefore + kBehind);
  scratch_.resize(kLanes, width_);
  bool all_finite = true;
  for (int v = 0; v < height_; v += kLanes) {
    all_finite &= load_rows(image, v, scratch_.data());
    image_kernels::bspline_filter(scratch_.data(), width_, kLanes);
    for (int lane = 0; lane < std::min(kLanes, height_ - v); ++lane) {
      float* row = coefficients_.row(v + lane + kBefore);
      std::fill(row, row + coefficients_.width(), 0.0F);
      for (int u = 0; u < width_; ++u) row[u + kBefore] = scratch_.at(lane, u);
    }
  }
  // The zeros beside the image, too: whole lanes only.
  for (int u = 0; u < coefficients_.width(); u += kLanes) {
    image_kernels::bspline_filter(coefficients_.row(kBefore) + u, height_, coefficients_.width());
  }
  if (!all_finite) erase_coefficients_without_data(image, coefficients_);
  mirror_borders(width_, height_, coefficients_);
}

}  // namespace raylign
