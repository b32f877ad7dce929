// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/frame.h"

#include <string>

#include "raylign/base/error.h"
#include "raylign/tracking/depth_cells.h"

namespace raylign {
namespace {

using tracking::DepthCell;

}  // namespace

void Frame::assign(const ImageView& image, const PinholeCamera& camera, int max_levels) {
  camera.validate();
  PyramidOptions options;
  options.max_levels = max_levels;
  images_.assign(image, options);
  camera_ = camera;
  has_depth_ = false;
  gradients_.resize(static_cast<std::size_t>(images_.num_levels()));
  depth_cells_.resize(gradients_.size());
  for (auto& level : gradients_) level.is_ready = false;
  for (auto& level : depth_cells_) level.is_ready = false;
}

DepthPyramidOptions Frame::depth_options(int depth_width, int depth_height) const {
  if (depth_width != width(0) || depth_height != height(0)) {
    throw ShapeError("a depth map must have the image's size, got " + std::to_string(depth_width) +
                     " x " + std::to_string(depth_height) + " for an image of " +
                     std::to_string(width(0)) + " x " + std::to_string(height(0)));
  }
  DepthPyramidOptions options;
  options.pyramid.max_levels = num_levels();
  return options;
}

void Frame::start_depth() {
  has_depth_ = true;
  for (auto& level : depth_cells_) level.is_ready = false;
}

void Frame::set_depth(const PlaneView<float>& inverse_depth, const PlaneView<float>& variance) {
  depth_.assign(inverse_depth, variance, depth_options(inverse_depth.width, inverse_depth.height));
  start_depth();
}

void Frame::adopt_depth(Plane<float>& inverse_depth, Plane<float>& variance) {
  depth_.adopt(inverse_depth, variance,
               depth_options(inverse_depth.width(), inverse_depth.height()));
  start_depth();
}

const GradientImage& Frame::gradients(int level) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Lazy<GradientImage>& lazy = gradients_[static_cast<std::size_t>(level)];
  if (!lazy.is_ready) make_gradient_image(images_.level(level).view(), lazy.value);
  lazy.is_ready = true;
  return lazy.value;
}

const Plane<DepthCell>& Frame::depth_cells(int level) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Lazy<Plane<DepthCell>>& lazy = depth_cells_[static_cast<std::size_t>(level)];
  if (!lazy.is_ready) {
    lazy.value.resize(width(level), height(level));
    tracking::make_depth_cells(depth_.inverse_depth(level).data(), depth_.variance(level).data(),
                               width(level), height(level), lazy.value.data());
  }
  lazy.is_ready = true;
  return lazy.value;
}

}  // namespace raylign
