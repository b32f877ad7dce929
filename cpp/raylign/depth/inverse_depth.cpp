// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/depth/inverse_depth.h"

#include <algorithm>
#include <cstdint>

#include "raylign/base/error.h"
#include "raylign/depth/inverse_depth_kernels.h"

namespace raylign {
namespace {

namespace kernels = depth_kernels;

// σ_D = constant + quadratic D² + beyond (1 − 0.4 D)²: each law with Z = 1/D put in.
struct NoiseCoefficients {
  float constant = 0.0F;
  float quadratic = 0.0F;
  float beyond = 0.0F;
};

NoiseCoefficients coefficients(const DepthModel& model) {
  const double s = model.effective_sigma();
  NoiseCoefficients result;
  switch (model.noise) {
    case DepthNoise::KINECT:
      result.quadratic = static_cast<float>(0.0012 * s);
      result.beyond = static_cast<float>(0.0019 * s);
      break;
    case DepthNoise::TIME_OF_FLIGHT:
      result.quadratic = static_cast<float>(s);
      break;
    case DepthNoise::DISPARITY:
      result.constant = static_cast<float>(s / model.focal_baseline);
      break;
    case DepthNoise::CONSTANT:
      result.constant = static_cast<float>(s);
      break;
  }
  return result;
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
  invert(depth, depth_scale, D);
  if (model_.edge_ratio > 0.0 && model_.edge_radius > 0) remove_edges(depth.width, depth.height, D);
  const NoiseCoefficients c = coefficients(model_);
  for (int v = 0; v < depth.height; ++v) {
    const std::int64_t first = std::int64_t{v} * depth.width;
    kernels::variance_row(D + first, depth.width, c.constant, c.quadratic, c.beyond, V + first);
  }
}

void InverseDepthConverter::invert(const ImageView& depth, double depth_scale, float* D) const {
  const auto near = static_cast<float>(model_.min_depth);
  const auto far = static_cast<float>(model_.max_depth);
  for (int v = 0; v < depth.height; ++v) {
    float* out = D + std::int64_t{v} * depth.width;
    const std::byte* row = row_of(depth, v);
    if (depth.type == PixelType::FLOAT32) {
      kernels::invert_row(reinterpret_cast<const float*>(row), depth.width, near, far, out);
    } else {
      kernels::invert_row(reinterpret_cast<const std::uint16_t*>(row), depth.width,
                          static_cast<float>(1.0 / depth_scale), near, far, out);
    }
  }
}

// The minimum and maximum over a window of radius r are those of radius 1, r times over.
void InverseDepthConverter::remove_edges(int width, int height, float* D) {
  const std::size_t size = static_cast<std::size_t>(width) * height;
  for (auto* buffer : {&low_, &high_, &low_row_, &high_row_}) buffer->resize(size);
  const auto row = [&](std::vector<float>& buffer, int v) {
    return buffer.data() + std::int64_t{std::clamp(v, 0, height - 1)} * width;
  };
  for (int v = 0; v < height; ++v) {
    kernels::start_extremes(D + std::int64_t{v} * width, width, row(low_, v), row(high_, v));
  }
  for (int pass = 0; pass < model_.edge_radius; ++pass) {
    for (int v = 0; v < height; ++v) {
      kernels::min3_row(row(low_, v), width, row(low_row_, v));
      kernels::max3_row(row(high_, v), width, row(high_row_, v));
    }
    for (int v = 0; v < height; ++v) {
      kernels::min3_rows(row(low_row_, v - 1), row(low_row_, v), row(low_row_, v + 1), width,
                         row(low_, v));
      kernels::max3_rows(row(high_row_, v - 1), row(high_row_, v), row(high_row_, v + 1), width,
                         row(high_, v));
    }
  }
  const auto ratio = static_cast<float>(model_.edge_ratio);
  for (int v = 0; v < height; ++v) {
    kernels::drop_edges_row(row(low_, v), row(high_, v), width, ratio, D + std::int64_t{v} * width);
  }
}

}  // namespace raylign
