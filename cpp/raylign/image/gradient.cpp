// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/gradient.h"

#include <algorithm>
#include <array>
#include <vector>

#include "raylign/image/kernels.h"

namespace raylign {
namespace {

// One pixel at the end of a row, with its neighbours clamped into the row.
GradientCell end_cell(const PlaneView<float>& image, int u, int v, float dv) {
  const int right = std::min(u + 1, image.width - 1);
  const int left = std::max(u - 1, 0);
  const float* row = image.row(v);
  const float du =
      right > left ? (row[right] - row[left]) / static_cast<float>(right - left) : 0.0F;
  return {row[u], du, dv, 0.0F};
}

void gradient_row(const PlaneView<float>& image, int v, GradientCell* out) {
  const int lower = std::min(v + 1, image.height - 1);
  const int upper = std::max(v - 1, 0);
  const float* above = image.row(upper);
  const float* below = image.row(lower);
  const float scale_v = lower - upper == 2 ? 0.5F : 1.0F;  // of one row the difference is 0
  if (image.width > 2) {
    image_kernels::gradient_cells(above + 1, image.row(v) + 1, below + 1, scale_v, image.width - 2,
                                  reinterpret_cast<float*>(out + 1));
  }
  for (const int u : {0, image.width - 1}) {
    out[u] = end_cell(image, u, v, scale_v * (below[u] - above[u]));
  }
}

}  // namespace

void make_gradient_image(const PlaneView<float>& image, GradientImage& cells) {
  cells.resize(image.width, image.height);
  if (image.empty()) return;
  for (int v = 0; v < image.height; ++v) gradient_row(image, v, cells.row(v));
}

void make_max_gradient(const PlaneView<GradientCell>& cells, Plane<float>& maximum) {
  const int width = cells.width;
  maximum.resize(width, cells.height);
  if (cells.empty()) return;
  // Maxima along the rows, in a ring of three rows with a zero on either side.
  const std::size_t padded = static_cast<std::size_t>(width) + 2;
  std::vector<float> squared(padded, 0.0F);
  std::array<std::vector<float>, 3> ring;
  for (auto& row : ring) row.assign(static_cast<std::size_t>(width), 0.0F);
  const auto fill = [&](int v) {
    image_kernels::squared_gradient(reinterpret_cast<const float*>(cells.row(v)), width,
                                    squared.data() + 1);
    image_kernels::maximum(squared.data(), squared.data() + 1, squared.data() + 2, width,
                           ring[v % 3].data());
  };
  std::vector<float> largest(static_cast<std::size_t>(width));
  fill(0);
  for (int v = 0; v < cells.height; ++v) {
    const int below = std::min(v + 1, cells.height - 1);
    if (below > v) fill(below);
    image_kernels::maximum(ring[std::max(v - 1, 0) % 3].data(), ring[v % 3].data(),
                           ring[below % 3].data(), width, largest.data());
    image_kernels::square_root(largest.data(), width, maximum.row(v));
  }
}

}  // namespace raylign
