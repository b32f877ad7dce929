// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/depth/inverse_depth.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/depth/inverse_depth_kernels.h"

namespace raylign {
namespace {

namespace kernels = depth_kernels;

DepthNoiseLaw<float> law_of(const DepthModel& model) {
  const DepthNoiseLaw<double> law = model.law();
  return {static_cast<float>(law.constant), static_cast<float>(law.c0), static_cast<float>(law.c1)};
}

const std::byte* row_of(const ImageView& image, int v) {
  return static_cast<const std::byte*>(image.data) + v * image.row_stride;
}

}  // namespace

InverseDepthConverter::InverseDepthConverter(const DepthModel& model) : model_(model) {
  model.validate();
}

void InverseDepthConverter::check(const ImageView& depth, double depth_scale) const {
  depth.validate();
  if (depth.channels != 1 || depth.type == PixelType::UINT8) {
    throw ShapeError("depth must be a float32 (m) or uint16 image with one channel");
  }
  require_option(depth_scale > 0, "depth_scale", "> 0 (units per m)", depth_scale);
}

void InverseDepthConverter::convert(const ImageView& depth,
                                    double depth_scale,
                                    float* D,
                                    float* V) {
  check(depth, depth_scale);
  const DepthNoiseLaw<float> law = law_of(model_);
  const bool removes_edges = model_.edge_ratio > 0.0 && model_.edge_radius > 0;
  const int delay = removes_edges ? model_.edge_radius : 0;
  const int width = depth.width;
  const int height = depth.height;
  if (removes_edges) {
    const auto rows = static_cast<std::size_t>(2 * delay + 2);  // the last: scratch
    low_.resize(rows * static_cast<std::size_t>(width));
    high_.resize(low_.size());
  }
  // row by row, so that what a row is made of is still in the cache
  for (int v = 0; v < height + delay; ++v) {
    if (v < height) invert_row(depth, depth_scale, v, D + std::int64_t{v} * width);
    if (!removes_edges) {
      kernels::variance_row(D + std::int64_t{v} * width, width, law, V + std::int64_t{v} * width);
      continue;
    }
    if (v < height) start_row(D + std::int64_t{v} * width, v, width);
    if (v >= delay) finish_row(v - delay, width, height, D, V);
  }
}

void InverseDepthConverter::invert_row(const ImageView& depth,
                                       double depth_scale,
                                       int v,
                                       float* D) const {
  const auto near = static_cast<float>(model_.min_depth);
  const auto far = static_cast<float>(model_.max_depth);
  const std::byte* row = row_of(depth, v);
  if (depth.type == PixelType::FLOAT32) {
    kernels::invert_row(reinterpret_cast<const float*>(row), depth.width, near, far, D);
  } else {
    kernels::invert_row(reinterpret_cast<const std::uint16_t*>(row), depth.width,
                        static_cast<float>(1.0 / depth_scale), near, far, D);
  }
}

float* InverseDepthConverter::ring_row(std::vector<float>& ring, int v, int width) {
  return ring.data() + std::int64_t{v % (2 * model_.edge_radius + 1)} * width;
}

// The minimum and maximum over a window of radius r are those of radius 1, r times over: here along
// the row, in finish_row across rows.
void InverseDepthConverter::start_row(const float* D, int v, int width) {
  const auto scratch_row = [&](std::vector<float>& ring) {
    return ring.data() + std::int64_t{2 * model_.edge_radius + 1} * width;
  };
  float* low = ring_row(low_, v, width);
  float* high = ring_row(high_, v, width);
  if (model_.edge_radius == 2) return kernels::wide_extremes_row(D, width, low, high);
  float* other_low = scratch_row(low_);
  float* other_high = scratch_row(high_);
  // to and fro, such that the last pass ends in the ring
  if (model_.edge_radius % 2 == 0) {
    std::swap(low, other_low);
    std::swap(high, other_high);
  }
  kernels::extremes_row(D, width, low, high);
  for (int pass = 1; pass < model_.edge_radius; ++pass) {
    kernels::min3_row(low, width, other_low);
    kernels::max3_row(high, width, other_high);
    std::swap(low, other_low);
    std::swap(high, other_high);
  }
}

void InverseDepthConverter::finish_row(int v, int width, int height, float* D, float* V) {
  const int radius = model_.edge_radius;
  const auto window = [&](std::vector<float>& ring, auto reduce) {
    const auto row = [&](int k) -> const float* {
      return ring_row(ring, std::clamp(v + k, 0, height - 1), width);
    };
    float* scratch = ring.data() + std::int64_t{2 * radius + 1} * width;
    const float* middle = row(0);
    for (int k = radius; k > 2; --k) {
      reduce(kernels::Rows{row(-k), middle, row(k)}, width, scratch);
      middle = scratch;
    }
    const int last = std::min(radius, 2);
    return kernels::FiveRows{row(-last), row(-1), middle, row(1), row(last)};
  };
  const std::int64_t first = std::int64_t{v} * width;
  kernels::finish_row(window(low_, kernels::min3_rows), window(high_, kernels::max3_rows), width,
                      static_cast<float>(model_.edge_ratio), law_of(model_), D + first, V + first);
}

}  // namespace raylign
