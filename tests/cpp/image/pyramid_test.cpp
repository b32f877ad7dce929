// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/pyramid.h"

#include <gtest/gtest.h>

#include <limits>

#include "image/images.h"
#include "raylign/base/error.h"
#include "raylign/camera/pinhole.h"

namespace raylign::test {
namespace {

template <typename Pixel>
class GreyTest : public testing::Test {
 protected:
  static double scale() { return sizeof(Pixel) == 2 ? 257.0 : 1.0; }
};
using Pixels = testing::Types<std::uint8_t, std::uint16_t, float>;
TYPED_TEST_SUITE(GreyTest, Pixels);

TYPED_TEST(GreyTest, OneChannelIsScaledOnly) {
  for (const auto& [width, height] : awkward_sizes()) {
    const Noise<TypeParam> noise(width, height);
    Plane<float> grey;
    to_grey(noise.view(), ColorOrder::RGB, grey);
    ASSERT_EQ(grey.width(), width);
    ASSERT_EQ(grey.height(), height);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        ASSERT_EQ(grey.at(u, v),
                  static_cast<float>(noise.at(u, v)) / static_cast<float>(this->scale()));
      }
    }
  }
}

TYPED_TEST(GreyTest, ColorIsWeighedInItsOrder) {
  const Noise<TypeParam> noise(61, 9, 3);
  Plane<float> rgb;
  Plane<float> bgr;
  to_grey(noise.view(), ColorOrder::RGB, rgb);
  to_grey(noise.view(), ColorOrder::BGR, bgr);
  for (int v = 0; v < 9; ++v) {
    for (int u = 0; u < 61; ++u) {
      const double a = noise.at(u, v, 0) / this->scale();
      const double g = noise.at(u, v, 1) / this->scale();
      const double c = noise.at(u, v, 2) / this->scale();
      ASSERT_NEAR(rgb.at(u, v), 0.299 * a + 0.587 * g + 0.114 * c, 1e-4);
      ASSERT_NEAR(bgr.at(u, v), 0.114 * a + 0.587 * g + 0.299 * c, 1e-4);
    }
  }
}

TEST(Grey, FullScaleIs255) {
  const std::uint16_t white = 65535;
  Plane<float> grey;
  to_grey({&white, PixelType::UINT16, 1, 1, 1, 2}, ColorOrder::RGB, grey);
  EXPECT_EQ(grey.at(0, 0), 255.0F);
}

TEST(Grey, RefusesAnEmptyImage) {
  Plane<float> grey;
  EXPECT_THROW(to_grey(ImageView{}, ColorOrder::RGB, grey), ShapeError);
}

TEST(ImagePyramid, PixelsAreMeansOfFour) {
  for (const auto& [width, height] : awkward_sizes()) {
    const Noise<std::uint8_t> noise(width, height);
    const ImagePyramid pyramid(noise.view(), {20, 1});
    for (int l = 1; l < pyramid.num_levels(); ++l) {
      const Plane<float>& fine = pyramid.level(l - 1);
      const Plane<float>& coarse = pyramid.level(l);
      ASSERT_EQ(coarse.width(), fine.width() / 2);
      ASSERT_EQ(coarse.height(), fine.height() / 2);
      for (int v = 0; v < coarse.height(); ++v) {
        for (int u = 0; u < coarse.width(); ++u) {
          const float upper = fine.at(2 * u, 2 * v) + fine.at(2 * u + 1, 2 * v);
          const float lower = fine.at(2 * u, 2 * v + 1) + fine.at(2 * u + 1, 2 * v + 1);
          ASSERT_EQ(coarse.at(u, v), 0.25F * (upper + lower));  // the same bits in every clone
        }
      }
    }
  }
}

TEST(ImagePyramid, LevelsEndAtTheShortestSide) {
  EXPECT_EQ(num_pyramid_levels(640, 480, {}), 5);
  EXPECT_EQ(num_pyramid_levels(640, 480, {9, 16}), 5);  // the next would have 15 rows
  EXPECT_EQ(num_pyramid_levels(640, 480, {9, 15}), 6);
  EXPECT_EQ(num_pyramid_levels(641, 479, {9, 16}), 5);
  EXPECT_EQ(num_pyramid_levels(640, 480, {3, 16}), 3);
  EXPECT_EQ(num_pyramid_levels(1, 1, {}), 1);
  EXPECT_EQ(num_pyramid_levels(16, 16, {}), 1);
  EXPECT_EQ(num_pyramid_levels(32, 4000, {}), 2);
  EXPECT_EQ(num_pyramid_levels(8, 8, {20, 1}), 4);
}

TEST(ImagePyramid, AssignKeepsItsMemory) {
  const Noise<std::uint8_t> first(61, 47);
  const Noise<std::uint16_t> second(61, 47);
  ImagePyramid pyramid(first.view(), {3, 1});
  const float* memory[3];
  for (int l = 0; l < 3; ++l) memory[l] = pyramid.level(l).data();
  pyramid.assign(second.view(), {3, 1});
  const ImagePyramid fresh(second.view(), {3, 1});
  for (int l = 0; l < 3; ++l) {
    EXPECT_EQ(pyramid.level(l).data(), memory[l]);
    for (std::size_t i = 0; i < fresh.level(l).size(); ++i) {
      ASSERT_EQ(pyramid.level(l).data()[i], fresh.level(l).data()[i]);
    }
  }
}

TEST(ImagePyramid, MissingDataStaysMissing) {
  Plane<float> image = plane_of(8, 8, [](int, int) { return 50.0; });
  image.at(3, 5) = std::numeric_limits<float>::quiet_NaN();
  const ImagePyramid pyramid(view_of(image), {3, 1});
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 4; ++u) {
      EXPECT_EQ(std::isnan(pyramid.level(1).at(u, v)), u == 1 && v == 2);
    }
  }
}

TEST(ImagePyramid, RefusesWhatCannotBe) {
  EXPECT_THROW(ImagePyramid(ImageView{}), ShapeError);
  const Noise<std::uint8_t> noise(4, 4);
  EXPECT_THROW(ImagePyramid(noise.view(), {0, 16}), OptionsError);
  EXPECT_THROW(ImagePyramid(noise.view(), {1, 0}), OptionsError);
}

// What the camera of level l sees at a pixel is what the box filter put there: an image of a linear
// function of the ray is, at every level, that function of the ray of the level's camera.
TEST(ImagePyramid, CameraOfALevelFitsTheFilter) {
  const PinholeCamera camera(525.0, 480.0, 63.2, 40.7);
  const auto ramp = [](const PinholeCamera& c, int u, int v) {
    return 100.0 + 300.0 * (u - c.cx()) / c.fx() - 200.0 * (v - c.cy()) / c.fy();
  };
  const Plane<float> image = plane_of(131, 97, [&](int u, int v) { return ramp(camera, u, v); });
  const ImagePyramid pyramid(view_of(image), {5, 1});
  ASSERT_EQ(pyramid.num_levels(), 5);
  for (int l = 0; l < 5; ++l) {
    const Plane<float>& level = pyramid.level(l);
    const PinholeCamera level_camera = camera.at_level(l);
    for (int v = 0; v < level.height(); ++v) {
      for (int u = 0; u < level.width(); ++u) {
        ASSERT_NEAR(level.at(u, v), ramp(level_camera, u, v), 2e-4) << l;
      }
    }
  }
}

TEST(ImagePyramid, CameraOfALevelComposes) {
  const PinholeCamera camera(525.0, 480.0, 319.5, 239.25);
  EXPECT_EQ(camera.at_level(0).params(), camera.params());
  EXPECT_EQ(camera.at_level(2).at_level(1).params(), camera.at_level(3).params());
  EXPECT_EQ(camera.at_level(1).cx(), 159.5);  // the centre of 640 columns is that of 320
  EXPECT_THROW(camera.at_level(-1), OptionsError);
}

}  // namespace
}  // namespace raylign::test
