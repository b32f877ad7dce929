// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/depth_pyramid.h"

#include <utility>

#include "raylign/image/kernels.h"

namespace raylign {

void DepthPyramidOptions::validate() const {
  pyramid.validate();
  require_option(max_depth_ratio > 1.0, "DepthPyramidOptions.max_depth_ratio", "> 1",
                 max_depth_ratio);
}

void DepthPyramid::make_levels(int width, int height, const DepthPyramidOptions& options) {
  options.validate();
  if (width == 0 || height == 0) throw ShapeError("a depth map must have at least one pixel");
  levels_.resize(num_pyramid_levels(width, height, options.pyramid));
}

void DepthPyramid::assign(const PlaneView<float>& inverse_depth,
                          const PlaneView<float>& variance,
                          const DepthPyramidOptions& options) {
  const int width = inverse_depth.width;
  const int height = inverse_depth.height;
  if (width != variance.width || height != variance.height) {
    throw ShapeError("inverse depth and variance must have the same size");
  }
  make_levels(width, height, options);
  Level& finest = levels_.front();
  finest.D.resize(width, height);
  finest.V.resize(width, height);
  for (int v = 0; v < height; ++v) {
    image_kernels::mark_depth(inverse_depth.row(v), variance.row(v), width, finest.D.row(v),
                              finest.V.row(v));
  }
  halve(options);
}

void DepthPyramid::adopt(Plane<float>& inverse_depth,
                         Plane<float>& variance,
                         const DepthPyramidOptions& options) {
  if (inverse_depth.width() != variance.width() || inverse_depth.height() != variance.height()) {
    throw ShapeError("inverse depth and variance must have the same size");
  }
  make_levels(inverse_depth.width(), inverse_depth.height(), options);
  std::swap(levels_.front().D, inverse_depth);
  std::swap(levels_.front().V, variance);
  halve(options);
}

void DepthPyramid::halve(const DepthPyramidOptions& options) {
  const auto ratio = static_cast<float>(options.max_depth_ratio);
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    const Level& fine = levels_[l - 1];
    Level& coarse = levels_[l];
    coarse.D.resize(fine.D.width() / 2, fine.D.height() / 2);
    coarse.V.resize(coarse.D.width(), coarse.D.height());
    for (int v = 0; v < coarse.D.height(); ++v) {
      image_kernels::halve_depth(
          {{fine.D.row(2 * v), fine.D.row(2 * v + 1)}, {fine.V.row(2 * v), fine.V.row(2 * v + 1)}},
          ratio, coarse.D.width(), coarse.D.row(v), coarse.V.row(v));
    }
  }
}

}  // namespace raylign
