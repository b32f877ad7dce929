// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "raylign/image/image_view.h"
#include "raylign/image/plane.h"

namespace raylign::test {

template <typename Pixel>
constexpr PixelType pixel_type() {
  return sizeof(Pixel) == 1   ? PixelType::UINT8
         : sizeof(Pixel) == 2 ? PixelType::UINT16
                              : PixelType::FLOAT32;
}

/// Pseudo-random pixels in rows with a tail of garbage, as a crop of a larger image has.
template <typename Pixel>
struct Noise {
  Noise(int width_, int height_, int channels_ = 1, int padding = 3)
      : width(width_), height(height_), channels(channels_), row(width_ * channels_ + padding) {
    std::uint32_t state = 12345U + static_cast<std::uint32_t>(width + 7 * height);
    for (int i = 0; i < row * height; ++i) {
      state = state * 1664525U + 1013904223U;
      pixels.push_back(static_cast<Pixel>(sizeof(Pixel) == 2 ? state >> 16U : state >> 24U));
    }
  }

  Pixel at(int u, int v, int c = 0) const { return pixels[v * row + u * channels + c]; }
  ImageView view() const {
    return {pixels.data(), pixel_type<Pixel>(), width, height, channels, row * sizeof(Pixel)};
  }
  PlaneView<float> plane() const { return {pixels.data(), width, height, row}; }

  int width;
  int height;
  int channels;
  int row;
  std::vector<Pixel> pixels;
};

/// I(u, v) = f(u, v).
template <typename F>
Plane<float> plane_of(int width, int height, const F& f) {
  Plane<float> plane(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) plane.at(u, v) = static_cast<float>(f(u, v));
  }
  return plane;
}

inline ImageView view_of(const Plane<float>& plane) {
  return {plane.data(),
          PixelType::FLOAT32,
          plane.width(),
          plane.height(),
          1,
          sizeof(float) * plane.width()};
}

/// Sizes that are odd, tiny, or not a multiple of a vector.
inline std::vector<std::pair<int, int>> awkward_sizes() {
  return {{1, 1}, {2, 1}, {1, 7}, {3, 3}, {16, 16}, {17, 33}, {61, 47}, {641, 479}};
}

}  // namespace raylign::test
