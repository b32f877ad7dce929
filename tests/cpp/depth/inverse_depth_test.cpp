// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/depth/inverse_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "raylign/base/error.h"

namespace raylign::test {
namespace {

DepthModel model_of(DepthNoise noise) {
  DepthModel model;
  model.noise = noise;
  model.focal_baseline = 40.0;
  model.edge_ratio = 0.0;
  return model;
}

struct Maps {
  std::vector<float> D, V;
};

template <typename Pixel>
Maps convert(const DepthModel& model,
             const std::vector<Pixel>& depth,
             int width,
             double depth_scale = 1000.0) {
  const auto height = static_cast<int>(depth.size()) / width;
  const PixelType type = sizeof(Pixel) == 4 ? PixelType::FLOAT32 : PixelType::UINT16;
  const ImageView view{depth.data(), type, width, height, 1, sizeof(Pixel) * width};
  Maps maps{std::vector<float>(depth.size(), -7.0F), std::vector<float>(depth.size(), -7.0F)};
  InverseDepthConverter(model).convert(view, depth_scale, maps.D.data(), maps.V.data());
  return maps;
}

class EveryLaw : public testing::TestWithParam<DepthNoise> {};

TEST_P(EveryLaw, VarianceIsTheSquareOfTheModelsSigma) {
  const DepthModel model = model_of(GetParam());
  std::vector<float> depth;
  for (double z = 0.3; z < 8.0; z *= 1.07) depth.push_back(static_cast<float>(z));
  const Maps maps = convert(model, depth, static_cast<int>(depth.size()));
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const double sigma = model.inverse_depth_sigma(depth[i]);
    EXPECT_NEAR(maps.D[i], 1.0 / depth[i], 1e-6);
    EXPECT_NEAR(maps.V[i] / (sigma * sigma), 1.0, 1e-5) << depth[i];
  }
}

INSTANTIATE_TEST_SUITE_P(Depth,
                         EveryLaw,
                         testing::Values(DepthNoise::KINECT,
                                         DepthNoise::DISPARITY,
                                         DepthNoise::TIME_OF_FLIGHT,
                                         DepthNoise::CONSTANT),
                         [](const auto& law) { return to_string(law.param); });

// The claim of LSD-SLAM's RGB-D remark: a Kinect's inverse depth has nearly constant variance.
TEST(DepthModel, KinectIsNearlyConstantInInverseDepth) {
  const DepthModel kinect = model_of(DepthNoise::KINECT);
  const double reference = kinect.inverse_depth_sigma(2.0);
  for (double z = 1.0; z <= 6.0; z += 0.1) {
    EXPECT_NEAR(kinect.inverse_depth_sigma(z) / reference, 1.0, 0.3) << z;
    // … while that of the depth itself grows by a factor of 20 over this range
  }
  EXPECT_GT(kinect.inverse_depth_sigma(6.0) * 36 / kinect.inverse_depth_sigma(1.0), 20.0);
}

TEST(InverseDepth, WhatIsNoDepthIsZeroInBothMaps) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const Maps maps = convert<float>(model_of(DepthNoise::KINECT),
                                   {kNan, kInf, -kInf, 0.0F, -1.0F, 0.05F, 25.0F, 2.0F}, 8);
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(maps.D[i], 0.0F) << i;
    EXPECT_EQ(maps.V[i], 0.0F) << i;
  }
  EXPECT_EQ(maps.D[7], 0.5F);
  EXPECT_GT(maps.V[7], 0.0F);
}

TEST(InverseDepth, ReadsSixteenBitUnits) {
  DepthModel model = model_of(DepthNoise::CONSTANT);
  model.max_depth = 100.0;
  const Maps maps = convert<std::uint16_t>(model, {0, 65535, 10000, 5000}, 4, 5000.0);
  EXPECT_EQ(maps.D, (std::vector<float>{0.0F, 0.0F, 0.5F, 1.0F}));
}

TEST(InverseDepth, DropsBothSidesOfAStepAndKeepsASlope) {
  constexpr int kWidth = 40;
  constexpr int kHeight = 9;
  std::vector<float> depth(kWidth * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) depth[v * kWidth + u] = u < 20 ? 1.0F + 0.01F * u : 2.0F;
  }
  for (const int radius : {1, 2, 3}) {
    DepthModel model = model_of(DepthNoise::KINECT);
    model.edge_ratio = 0.1;
    model.edge_radius = radius;
    const Maps maps = convert(model, depth, kWidth);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const bool near_step = u >= 20 - radius && u < 20 + radius;
        EXPECT_EQ(maps.D[v * kWidth + u] == 0.0F, near_step) << u << ' ' << v << ' ' << radius;
      }
    }
  }
}

// A hole is no step: what lies beside it stays.
TEST(InverseDepth, AHoleIsNotAStep) {
  DepthModel model = model_of(DepthNoise::KINECT);
  model.edge_ratio = 0.1;
  const Maps maps = convert<float>(model, {2.0F, 2.0F, 0.0F, 2.0F, 2.0F}, 5);
  EXPECT_EQ(maps.D, (std::vector<float>{0.5F, 0.5F, 0.0F, 0.5F, 0.5F}));
}

TEST(InverseDepth, EverySizeDownToOnePixel) {
  DepthModel model = model_of(DepthNoise::KINECT);
  model.edge_ratio = 0.1;
  model.edge_radius = 2;
  for (const int width : {1, 2, 3, 17}) {
    for (const int height : {1, 2, 5}) {
      const Maps maps = convert(model, std::vector<float>(width * height, 2.0F), width);
      for (const float D : maps.D) EXPECT_EQ(D, 0.5F);
    }
  }
}

TEST(InverseDepth, RefusesWhatIsNoDepthImage) {
  const std::vector<std::uint8_t> bytes(16);
  float out[16];
  InverseDepthConverter converter{DepthModel()};
  EXPECT_THROW(converter.convert({bytes.data(), PixelType::UINT8, 4, 4, 1, 4}, 1.0, out, out),
               ShapeError);
  EXPECT_THROW(converter.convert({bytes.data(), PixelType::UINT16, 4, 2, 1, 8}, 0.0, out, out),
               OptionsError);
}

TEST(DepthModel, RefusesImpossibleValues) {
  const auto refused = [](auto change) {
    DepthModel model;
    change(model);
    EXPECT_THROW(model.validate(), OptionsError);
  };
  refused([](DepthModel& m) { m.sigma = -1.0; });
  refused([](DepthModel& m) { m.sigma = NAN; });
  refused([](DepthModel& m) { m.noise = DepthNoise::DISPARITY; });
  refused([](DepthModel& m) { m.min_depth = 0.0; });
  refused([](DepthModel& m) { m.max_depth = m.min_depth; });
  refused([](DepthModel& m) { m.edge_ratio = -0.1; });
  refused([](DepthModel& m) { m.edge_radius = 17; });
}

}  // namespace
}  // namespace raylign::test
