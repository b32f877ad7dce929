// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/patch_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/images.h"
#include "support/named_rng.h"

namespace raylign {
namespace {

constexpr SampleInterpolation kAll[] = {SampleInterpolation::BILINEAR,
                                        SampleInterpolation::CENTRAL_DIFFERENCE,
                                        SampleInterpolation::CUBIC_BSPLINE};

ImagePyramid noise_pyramid(int width, int height, int levels) {
  return ImagePyramid(test::Noise<float>(width, height).view(), {levels, 1});
}

// The exercise's reading of a row-major image without borders: what follows in memory.
double in_memory(const Plane<float>& image, int u, int v) {
  return image.data()[v * image.width() + u];
}

TEST(PatchImage, SamplesLikeTheImageModule) {
  const ImagePyramid pyramid = noise_pyramid(41, 33, 3);
  auto rng = test::make_rng("patch image samples");
  for (const SampleInterpolation interpolation : kAll) {
    const PatchImage image(pyramid, interpolation);
    ASSERT_EQ(image.num_levels(), 3);
    for (int level = 0; level < 3; ++level) {
      const PlaneView<float> plane = pyramid.level(level).view();
      EXPECT_EQ(image.width(level), plane.width);
      EXPECT_EQ(image.height(level), plane.height);
      for (int k = 0; k < 50; ++k) {
        // inside by 1 px: at the border the image module has one-sided differences
        const double uv[] = {rng.uniform(1.0, plane.width - 2.0),
                             rng.uniform(1.0, plane.height - 2.0)};
        double value = 0.0;
        double gradient[2];
        bool valid = false;
        sample_points(plane, interpolation, {1, uv, &value, gradient, &valid});
        ASSERT_TRUE(valid);
        const Sample<double> got =
            sample_patch_plane(image.plane(level), interpolation, uv[0], uv[1]);
        EXPECT_NEAR(got.value, value, 2e-4);  // the image module may work in float
        EXPECT_NEAR(got.du, gradient[0], 2e-4);
        EXPECT_NEAR(got.dv, gradient[1], 2e-4);
      }
    }
  }
}

TEST(PatchImage, ReplicatedBordersEndAtTheLastPixel) {
  const ImagePyramid pyramid = noise_pyramid(20, 17, 1);
  for (const SampleInterpolation interpolation : kAll) {
    const PatchImage image(pyramid, interpolation);
    const PatchPlane& plane = image.plane(0);
    EXPECT_TRUE(plane.contains(0.0, 0.0));
    EXPECT_TRUE(plane.contains(19.0, 16.0));
    EXPECT_FALSE(plane.contains(std::nextafter(19.0, 20.0), 3.0));
    EXPECT_FALSE(plane.contains(3.0, std::nextafter(16.0, 20.0)));
    EXPECT_FALSE(plane.contains(-1e-300, 3.0));
    EXPECT_FALSE(plane.contains(3.0, -1e-300));
    EXPECT_FALSE(plane.contains(std::numeric_limits<double>::quiet_NaN(), 3.0));
    for (const auto& uv : {std::pair{0, 0}, {19, 0}, {0, 16}, {19, 16}}) {
      const Sample<double> s = sample_patch_plane(plane, interpolation, uv.first, uv.second);
      EXPECT_NEAR(s.value, pyramid.level(0).at(uv.first, uv.second), 1e-3);
      EXPECT_TRUE(std::isfinite(s.du) && std::isfinite(s.dv));
    }
  }
}

TEST(PatchImage, ReplicatedCentralDifferencesSeeTheBorderPixelTwice) {
  const ImagePyramid pyramid = noise_pyramid(20, 17, 1);
  const PatchImage image(pyramid, SampleInterpolation::CENTRAL_DIFFERENCE);
  const Plane<float>& I = pyramid.level(0);
  const auto sample = [&](double u, double v) {
    return sample_patch_plane(image.plane(0), SampleInterpolation::CENTRAL_DIFFERENCE, u, v);
  };
  EXPECT_DOUBLE_EQ(sample(19.0, 5.0).du, 0.5 * (double(I.at(19, 5)) - I.at(18, 5)));
  EXPECT_DOUBLE_EQ(sample(0.0, 5.0).du, 0.5 * (double(I.at(1, 5)) - I.at(0, 5)));
  EXPECT_DOUBLE_EQ(sample(4.0, 0.0).dv, 0.5 * (double(I.at(4, 1)) - I.at(4, 0)));
  EXPECT_DOUBLE_EQ(sample(4.0, 16.0).dv, 0.5 * (double(I.at(4, 16)) - I.at(4, 15)));
}

TEST(PatchImage, WrappedBordersReadOnInMemory) {
  const ImagePyramid pyramid = noise_pyramid(20, 17, 1);
  const Plane<float>& I = pyramid.level(0);
  const PatchImage image(pyramid, SampleInterpolation::CENTRAL_DIFFERENCE, PatchBorder::WRAP);
  const PatchPlane& plane = image.plane(0);
  EXPECT_TRUE(plane.contains(std::nextafter(20.0, 0.0), std::nextafter(17.0, 0.0)));
  EXPECT_FALSE(plane.contains(20.0, 3.0));
  EXPECT_FALSE(plane.contains(3.0, 17.0));
  EXPECT_FALSE(plane.contains(-1e-300, 3.0));
  const auto sample = [&](double u, double v) {
    return sample_patch_plane(plane, SampleInterpolation::CENTRAL_DIFFERENCE, u, v);
  };
  // between the last pixel of row 4 and the first of row 5
  const double x = 0.375;
  EXPECT_DOUBLE_EQ(sample(19.0 + x, 4.0).value,
                   (1.0 - x) * in_memory(I, 19, 4) + x * in_memory(I, 20, 4));
  EXPECT_EQ(in_memory(I, 20, 4), I.at(0, 5));
  EXPECT_DOUBLE_EQ(sample(19.0, 4.0).du, 0.5 * (in_memory(I, 20, 4) - in_memory(I, 18, 4)));
  EXPECT_DOUBLE_EQ(sample(19.0 + x, 4.0).du,
                   0.5 * ((1.0 - x) * in_memory(I, 20, 4) + x * in_memory(I, 21, 4) -
                          (1.0 - x) * in_memory(I, 18, 4) - x * in_memory(I, 19, 4)));
  // the exercise reads the cell of the first column, and of the first row, for the one before it
  EXPECT_DOUBLE_EQ(sample(0.0, 4.0).du, 0.5 * (in_memory(I, 1, 4) - in_memory(I, 0, 4)));
  EXPECT_DOUBLE_EQ(sample(5.0, 0.0).dv, 0.5 * (in_memory(I, 5, 1) - in_memory(I, 5, 0)));
  // nothing lies before the first pixel or behind the last: those are seen twice
  EXPECT_DOUBLE_EQ(sample(0.0, 0.0).du, 0.5 * (double(I.at(1, 0)) - I.at(0, 0)));
  EXPECT_DOUBLE_EQ(sample(19.0, 16.0).value, I.at(19, 16));
  EXPECT_DOUBLE_EQ(sample(19.5, 16.0).value, I.at(19, 16));
  EXPECT_DOUBLE_EQ(sample(19.0, 16.5).value, I.at(19, 16));
}

TEST(PatchImage, TinyImagesAreReadWithoutLeavingTheirMemory) {
  for (const auto& [width, height] : test::awkward_sizes()) {
    const ImagePyramid pyramid = noise_pyramid(width, height, 2);
    for (const SampleInterpolation interpolation : kAll) {
      const PatchImage image(pyramid, interpolation);
      for (int level = 0; level < image.num_levels(); ++level) {
        const PatchPlane& plane = image.plane(level);
        for (const double u : {0.0, 0.5 * plane.max_u, plane.max_u}) {
          for (const double v : {0.0, 0.5 * plane.max_v, plane.max_v}) {
            const Sample<double> s = sample_patch_plane(plane, interpolation, u, v);
            EXPECT_TRUE(std::isfinite(s.value + s.du + s.dv));
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace raylign
