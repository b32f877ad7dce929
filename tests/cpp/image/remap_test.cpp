// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/remap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "raylign/base/error.h"

namespace raylign::test {
namespace {

using Map = Rows<float, Eigen::Dynamic>;

constexpr int kWidth = 31;
constexpr int kHeight = 17;

template <typename Pixel>
PixelType pixel_type();
template <>
PixelType pixel_type<std::uint8_t>() {
  return PixelType::UINT8;
}
template <>
PixelType pixel_type<std::uint16_t>() {
  return PixelType::UINT16;
}
template <>
PixelType pixel_type<float>() {
  return PixelType::FLOAT32;
}

// I(v, u, c) = 4 u + 2 v + c: bilinear interpolation of a plane is exact. Rows are padded.
template <typename Pixel>
struct Plane {
  static constexpr int kPadding = 5;

  explicit Plane(int channels_) : channels(channels_) {
    row = static_cast<std::size_t>(kWidth) * channels + kPadding;
    pixels.assign(row * kHeight, Pixel(99));
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        for (int c = 0; c < channels; ++c) pixels[v * row + u * channels + c] = value(u, v, c);
      }
    }
  }

  static Pixel value(double u, double v, int c) {
    return static_cast<Pixel>(4.0 * u + 2.0 * v + c);
  }

  ImageView view() const {
    return {pixels.data(), pixel_type<Pixel>(), kWidth, kHeight, channels, row * sizeof(Pixel)};
  }

  int channels;
  std::size_t row;
  std::vector<Pixel> pixels;
};

template <typename Pixel>
class RemapTest : public testing::Test {};
using Pixels = testing::Types<std::uint8_t, std::uint16_t, float>;
TYPED_TEST_SUITE(RemapTest, Pixels);

TYPED_TEST(RemapTest, InterpolatesAPlaneExactly) {
  for (const int channels : {1, 3}) {
    const Plane<TypeParam> plane(channels);
    Map map_x(4, 9), map_y(4, 9);
    for (int v = 0; v < 4; ++v) {
      for (int u = 0; u < 9; ++u) {
        map_x(v, u) = 2.25F * static_cast<float>(u) + 0.5F;
        map_y(v, u) = 3.5F * static_cast<float>(v);
      }
    }
    const Image result = remap(plane.view(), map_x, map_y);
    ASSERT_EQ(result.width(), 9);
    ASSERT_EQ(result.height(), 4);
    ASSERT_EQ(result.channels(), channels);
    ASSERT_EQ(result.type(), pixel_type<TypeParam>());
    const auto* pixels = static_cast<const TypeParam*>(result.data());
    for (int v = 0; v < 4; ++v) {
      for (int u = 0; u < 9; ++u) {
        for (int c = 0; c < channels; ++c) {
          EXPECT_EQ(pixels[(v * 9 + u) * channels + c],
                    Plane<TypeParam>::value(map_x(v, u), map_y(v, u), c));
        }
      }
    }
  }
}

TEST(Remap, OutsideAndNotFiniteAreZero) {
  const Plane<std::uint8_t> plane(1);
  Map map_x = Map::Constant(1, 6, 10.0F);
  const Map map_y = Map::Constant(1, 6, 8.0F);
  map_x.row(0) << -1e4F, 1e9F, std::numeric_limits<float>::quiet_NaN(),
      std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(), 10.0F;
  for (const Interpolation interpolation :
       {Interpolation::NEAREST, Interpolation::LINEAR, Interpolation::CUBIC}) {
    const Image result = remap(plane.view(), map_x, map_y, interpolation);
    const auto* pixels = static_cast<const std::uint8_t*>(result.data());
    for (int u = 0; u < 5; ++u) EXPECT_EQ(pixels[u], 0) << u;
    EXPECT_EQ(pixels[5], 56);
  }
}

TEST(Remap, NearestTakesAPixel) {
  const Plane<float> plane(1);
  const Image result = remap(plane.view(), Map::Constant(1, 1, 3.4F), Map::Constant(1, 1, 5.6F),
                             Interpolation::NEAREST);
  EXPECT_EQ(*static_cast<const float*>(result.data()), 4.0F * 3.0F + 2.0F * 6.0F);
}

TEST(Remap, RefusesWhatDoesNotFit) {
  const Plane<std::uint8_t> plane(1);
  EXPECT_THROW(remap(plane.view(), Map::Zero(2, 3), Map::Zero(3, 2)), ShapeError);
  EXPECT_THROW(remap(plane.view(), Map(0, 0), Map(0, 0)), ShapeError);
  EXPECT_THROW(remap(ImageView{}, Map::Zero(2, 2), Map::Zero(2, 2)), ShapeError);
  ImageView view = plane.view();
  view.width = 40000;
  view.height = 1;
  view.row_stride = 40000;
  EXPECT_THROW(remap(view, Map::Zero(1, 1), Map::Zero(1, 1)), ShapeError);
}

TEST(ImageView, ValidateFindsWhatCannotBe) {
  const Plane<std::uint16_t> plane(3);
  EXPECT_NO_THROW(plane.view().validate());
  EXPECT_NO_THROW(ImageView{}.validate());
  ImageView view = plane.view();
  view.channels = 2;
  EXPECT_THROW(view.validate(), ShapeError);
  view = plane.view();
  view.row_stride = kWidth * 3 * 2 - 2;
  EXPECT_THROW(view.validate(), ShapeError);
  view = plane.view();
  view.row_stride += 1;  // not a multiple of the pixel
  EXPECT_THROW(view.validate(), ShapeError);
  view = plane.view();
  view.data = nullptr;
  EXPECT_THROW(view.validate(), ShapeError);
  view = plane.view();
  view.height = -1;
  EXPECT_THROW(view.validate(), ShapeError);
}

TEST(Image, StartsAsZerosWithoutPadding) {
  const Image image(PixelType::FLOAT32, 5, 3, 3);
  EXPECT_EQ(image.row_stride(), 60U);
  for (int i = 0; i < 45; ++i) EXPECT_EQ(static_cast<const float*>(image.data())[i], 0.0F);
  EXPECT_THROW(Image(PixelType::UINT8, -1, 3, 1), ShapeError);
  EXPECT_THROW(Image(PixelType::UINT8, 3, 3, 4), ShapeError);
  EXPECT_TRUE(Image(PixelType::UINT8, 0, 3, 1).view().empty());
}

}  // namespace
}  // namespace raylign::test
