// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/sampled_noise.h"

#include <gtest/gtest.h>

#include "raylign/photometric/prepared_images.h"

namespace raylign::test {
namespace {

constexpr int kSide = 41;
constexpr int kMiddle = 20;

struct Variances {
  double value = 0.0;
  double slope = 0.0;
};

// Sums of the squared answers to one pixel after the other being 1. All pixels are alike, so one
// pixel is read at all distances instead.
Variances answers(SampleInterpolation interpolation, double presmooth, double x, double y) {
  Plane<float> impulse(kSide, kSide);
  for (std::size_t i = 0; i < impulse.size(); ++i) impulse.data()[i] = 0.0f;
  impulse.at(kMiddle, kMiddle) = 1.0f;
  if (presmooth > 0.0) impulse = photometric::smoothed(impulse, presmooth);
  PyramidOptions options;
  options.max_levels = 1;
  const PatchImage image(
      ImagePyramid({impulse.data(), PixelType::FLOAT32, kSide, kSide, 1, sizeof(float) * kSide},
                   options),
      interpolation);
  Variances sum;
  for (int v = 2; v < kSide - 3; ++v) {
    for (int u = 2; u < kSide - 3; ++u) {
      const Sample<double> sample = sample_patch_plane(image.plane(0), interpolation, u + x, v + y);
      sum.value += sample.value * sample.value;
      sum.slope += sample.du * sample.du;
    }
  }
  return sum;
}

struct Case {
  const char* name;
  SampleInterpolation interpolation;
  double presmooth;
};

class SampledNoiseTest : public testing::TestWithParam<Case> {
 protected:
  const SampledNoise noise_{GetParam().interpolation, GetParam().presmooth};
};

TEST_P(SampledNoiseTest, IsTheSumOfSquaredAnswers) {
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.25, 0.0}, {0.5, 0.75}}) {
    const Variances expected = answers(GetParam().interpolation, GetParam().presmooth, x, y);
    EXPECT_NEAR(noise_.value(7.0 + x, 5.0 + y), expected.value, 1e-5 * expected.value);
  }
}

TEST_P(SampledNoiseTest, MeansAreOverTheCell) {
  constexpr int kSteps = 16;
  Variances mean;
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps; ++k) {
      const Variances at = answers(GetParam().interpolation, GetParam().presmooth,
                                   (i + 0.5) / kSteps, (k + 0.5) / kSteps);
      mean.value += at.value / (kSteps * kSteps);
      mean.slope += at.slope / (kSteps * kSteps);
    }
  }
  EXPECT_NEAR(noise_.mean_value(), mean.value, 5e-3 * mean.value);
  EXPECT_NEAR(noise_.mean_gradient(), mean.slope, 5e-3 * mean.slope);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    SampledNoiseTest,
    testing::Values(Case{"bspline", SampleInterpolation::CUBIC_BSPLINE, 0.0},
                    Case{"bspline_smoothed", SampleInterpolation::CUBIC_BSPLINE, 0.7},
                    Case{"bilinear", SampleInterpolation::BILINEAR, 0.0},
                    Case{"bilinear_smoothed", SampleInterpolation::BILINEAR, 1.0},
                    Case{"central_difference", SampleInterpolation::CENTRAL_DIFFERENCE, 0.0}),
    [](const auto& test) { return test.param.name; });

TEST(SampledNoise, IsThatOfThePixelsAtWholePixels) {
  EXPECT_NEAR(SampledNoise(SampleInterpolation::CUBIC_BSPLINE).value(3.0, 4.0), 1.0, 1e-6);
  EXPECT_EQ(SampledNoise(SampleInterpolation::BILINEAR).value(3.0, 4.0), 1.0);
  EXPECT_NEAR(SampledNoise(SampleInterpolation::BILINEAR).mean_value(), 4.0 / 9.0, 1e-3);
  EXPECT_NEAR(SampledNoise(SampleInterpolation::CUBIC_BSPLINE).mean_value(), 0.76, 5e-3);
}

}  // namespace
}  // namespace raylign::test
