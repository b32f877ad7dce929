// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/gradient.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "image/images.h"

namespace raylign::test {
namespace {

// The rule of numpy.gradient, one pixel at a time.
float difference(float before, float here, float after, int x, int size) {
  if (size == 1) return 0.0F;
  if (x == 0) return after - here;
  if (x == size - 1) return here - before;
  return 0.5F * (after - before);
}

GradientCell expected_cell(const PlaneView<float>& image, int u, int v) {
  const int left = std::max(u - 1, 0);
  const int right = std::min(u + 1, image.width - 1);
  const int above = std::max(v - 1, 0);
  const int below = std::min(v + 1, image.height - 1);
  const float here = image.at(u, v);
  return {here, difference(image.at(left, v), here, image.at(right, v), u, image.width),
          difference(image.at(u, above), here, image.at(u, below), v, image.height), 0.0F};
}

TEST(GradientImage, IsTheScalarRuleBitForBit) {
  for (const auto& [width, height] : awkward_sizes()) {
    const Noise<float> noise(width, height);
    GradientImage cells;
    make_gradient_image(noise.plane(), cells);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const GradientCell expected = expected_cell(noise.plane(), u, v);
        ASSERT_EQ(cells.at(u, v).value, expected.value);
        ASSERT_EQ(cells.at(u, v).du, expected.du) << width << "x" << height << " " << u << " " << v;
        ASSERT_EQ(cells.at(u, v).dv, expected.dv);
        ASSERT_EQ(cells.at(u, v).zero, 0.0F);
      }
    }
  }
}

TEST(GradientImage, KeepsItsMemory) {
  const Noise<float> noise(61, 47);
  GradientImage cells;
  make_gradient_image(noise.plane(), cells);
  const GradientCell* memory = cells.data();
  make_gradient_image(noise.plane(), cells);
  EXPECT_EQ(cells.data(), memory);
}

TEST(MaxGradient, IsTheLargestOfNine) {
  for (const auto& [width, height] : awkward_sizes()) {
    const Noise<float> noise(width, height);
    GradientImage cells;
    Plane<float> maximum;
    make_gradient_image(noise.plane(), cells);
    make_max_gradient(cells.view(), maximum);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        float largest = 0.0F;
        for (int y = std::max(v - 1, 0); y <= std::min(v + 1, height - 1); ++y) {
          for (int x = std::max(u - 1, 0); x <= std::min(u + 1, width - 1); ++x) {
            const GradientCell& cell = cells.at(x, y);
            largest = std::max(largest, cell.du * cell.du + cell.dv * cell.dv);
          }
        }
        ASSERT_FLOAT_EQ(maximum.at(u, v), std::sqrt(largest));
      }
    }
  }
}

TEST(MaxGradient, MissingDataHasNoGradient) {
  Plane<float> image = plane_of(20, 10, [](int u, int) { return 3.0 * u; });
  image.at(9, 5) = std::numeric_limits<float>::quiet_NaN();
  GradientImage cells;
  Plane<float> maximum;
  make_gradient_image(image.view(), cells);
  EXPECT_TRUE(std::isnan(cells.at(9, 5).value));
  EXPECT_TRUE(std::isnan(cells.at(8, 5).du));
  make_max_gradient(cells.view(), maximum);
  for (std::size_t i = 0; i < maximum.size(); ++i) ASSERT_EQ(maximum.data()[i], 3.0F);
}

}  // namespace
}  // namespace raylign::test
