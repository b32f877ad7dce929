// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/frame.h"

#include <algorithm>

#include "raylign/base/error.h"

namespace raylign {
namespace {

using tracking::DepthCell;

// Four pixels are a basis for interpolation when their spread is that of one surface: noise of
// three σ and the slant of 5 % of the inverse depth between neighbours.
constexpr float kNoiseSpread = 18.0F;  // (3 √2)² on V
constexpr float kSlant = 0.05F;

bool is_one_surface(float low, float high, float variance) {
  const float spread = high - low;
  return spread <= kSlant * high || spread * spread <= kNoiseSpread * variance;
}

struct Neighbours {
  float before, here, after;
  float V_before, V_after;
};

// Central difference where both neighbours are on the surface, else one-sided, else zero.
float slope(const Neighbours& n, float V) {
  const bool has_before = n.V_before > 0.0F &&
                          is_one_surface(std::min(n.before, n.here), std::max(n.before, n.here), V);
  const bool has_after =
      n.V_after > 0.0F && is_one_surface(std::min(n.after, n.here), std::max(n.after, n.here), V);
  const float low = has_before ? n.before : n.here;
  const float high = has_after ? n.after : n.here;
  return (high - low) * (has_before && has_after ? 0.5F : 1.0F);
}

// Variance of the quad from (u, v) to the right and below, −1 when it is none.
float quad_variance(const Plane<float>& D, const Plane<float>& V, int u, int v) {
  if (u + 1 >= D.width() || v + 1 >= D.height()) return -1.0F;
  const float* d0 = D.row(v) + u;
  const float* d1 = D.row(v + 1) + u;
  const float* v0 = V.row(v) + u;
  const float* v1 = V.row(v + 1) + u;
  if (!(v0[0] > 0.0F && v0[1] > 0.0F && v1[0] > 0.0F && v1[1] > 0.0F)) return -1.0F;
  const float low = std::min(std::min(d0[0], d0[1]), std::min(d1[0], d1[1]));
  const float high = std::max(std::max(d0[0], d0[1]), std::max(d1[0], d1[1]));
  const float variance = 0.25F * (v0[0] + v0[1] + v1[0] + v1[1]);
  return is_one_surface(low, high, variance) ? variance : -1.0F;
}

void make_depth_cells(const Plane<float>& D, const Plane<float>& V, Plane<DepthCell>& cells) {
  const int width = D.width();
  const int height = D.height();
  cells.resize(width, height);
  for (int v = 0; v < height; ++v) {
    const int above = std::max(v - 1, 0);
    const int below = std::min(v + 1, height - 1);
    for (int u = 0; u < width; ++u) {
      const float variance = V.at(u, v);
      DepthCell& cell = cells.at(u, v);
      cell = {D.at(u, v), 0.0F, 0.0F, -1.0F};
      if (!(variance > 0.0F)) continue;
      const int left = std::max(u - 1, 0);
      const int right = std::min(u + 1, width - 1);
      cell.du = slope({D.at(left, v), cell.D, D.at(right, v), left < u ? V.at(left, v) : -1.0F,
                       right > u ? V.at(right, v) : -1.0F},
                      variance);
      cell.dv = slope({D.at(u, above), cell.D, D.at(u, below), above < v ? V.at(u, above) : -1.0F,
                       below > v ? V.at(u, below) : -1.0F},
                      variance);
      cell.variance = quad_variance(D, V, u, v);
    }
  }
}

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

void Frame::set_depth(const PlaneView<float>& inverse_depth, const PlaneView<float>& variance) {
  if (inverse_depth.width != width(0) || inverse_depth.height != height(0)) {
    throw ShapeError("a depth map must have the image's size, got " +
                     std::to_string(inverse_depth.width) + " x " +
                     std::to_string(inverse_depth.height) + " for an image of " +
                     std::to_string(width(0)) + " x " + std::to_string(height(0)));
  }
  DepthPyramidOptions options;
  options.pyramid.max_levels = num_levels();
  depth_.assign(inverse_depth, variance, options);
  has_depth_ = true;
  for (auto& level : depth_cells_) level.is_ready = false;
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
    make_depth_cells(depth_.inverse_depth(level), depth_.variance(level), lazy.value);
  }
  lazy.is_ready = true;
  return lazy.value;
}

}  // namespace raylign
