// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/pixel_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raylign/photometric/prepared_images.h"
#include "support/named_rng.h"

namespace raylign::test {
namespace {

// Waves of 12 px and a sharp edge, with noise.
Plane<float> texture(double sigma) {
  NamedRng rng(5);
  Plane<float> image(200, 150);
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      const double wave = std::sin(0.5 * u + 0.2 * v) + std::sin(0.1 * u - 0.5 * v);
      const double step = 2 * u + v > 300 ? 60.0 : 0.0;
      image.at(u, v) = static_cast<float>(90.0 + 25.0 * wave + step + sigma * rng.normal());
    }
  }
  return image;
}

TEST(PixelNoise, IsFoundUnderTexture) {
  for (const double sigma : {1.0, 2.0, 8.0}) {
    EXPECT_NEAR(estimate_pixel_noise(texture(sigma)), sigma, 0.05 * sigma) << sigma;
  }
  EXPECT_LT(estimate_pixel_noise(texture(0.0)), 0.3);
}

TEST(PixelNoise, TinyImagesHaveNone) { EXPECT_EQ(estimate_pixel_noise(Plane<float>(2, 9)), 0.0); }

PhotometricProblem problem_of(double sigma) {
  const Plane<float> image = texture(sigma);
  PhotometricProblem problem;
  problem.images = {std::make_shared<ImagePyramid>(
      ImageView{image.data(), PixelType::FLOAT32, image.width(), image.height(), 1,
                sizeof(float) * static_cast<std::size_t>(image.width())},
      PyramidOptions{})};
  return problem;
}

TEST(Presmooth, IsForNoisyImagesWithoutStoredPatches) {
  PhotometricOptions options;
  options.presmooth = -1.0;
  EXPECT_EQ(photometric::prepare_images(problem_of(0.3), options).presmooth, 0.0);
  PhotometricProblem noisy = problem_of(2.0);
  EXPECT_NEAR(photometric::prepare_images(noisy, options).presmooth, 0.424, 0.01);
  EXPECT_EQ(photometric::prepare_images(problem_of(20.0), options).presmooth, 0.7);
  options.presmooth = 0.9;
  EXPECT_EQ(photometric::prepare_images(noisy, options).presmooth, 0.9);
  options.presmooth = -1.0;
  noisy.patches.setZero(3, 16);
  EXPECT_EQ(photometric::prepare_images(noisy, options).presmooth, 0.0);
}

}  // namespace
}  // namespace raylign::test
