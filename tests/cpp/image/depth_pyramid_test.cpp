// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/depth_pyramid.h"

#include <gtest/gtest.h>

#include <limits>

#include "image/images.h"
#include "raylign/base/error.h"

namespace raylign::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Depth with holes of every kind.
struct Maps {
  Maps(int width, int height) : D(width, height), V(width, height) {
    const Noise<float> noise(width, height);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        D.at(u, v) = 0.2F + noise.at(u, v) / 255.0F;
        V.at(u, v) = 1e-4F * (1.0F + noise.at(width - 1 - u, v));
        switch ((u * 31 + v * 17) % 9) {
          case 0:
            D.at(u, v) = 0.0F;
            break;
          case 1:
            V.at(u, v) = 0.0F;
            break;
          case 2:
            D.at(u, v) = kNan;
            break;
          case 3:
            V.at(u, v) = kInfinity;
            break;
          case 4:
            D.at(u, v) = -1.0F;
            break;
          default:
            break;
        }
      }
    }
  }

  Plane<float> D;
  Plane<float> V;
};

bool has_depth(float D, float V) {
  return D > 0.0F && V > 0.0F && std::isfinite(D) && std::isfinite(V);
}

TEST(DepthPyramid, FollowsTheRuleOfOnePixelAtATime) {
  for (const auto& [width, height] : awkward_sizes()) {
    const Maps maps(width, height);
    const DepthPyramid pyramid(maps.D.view(), maps.V.view(), {{20, 1}});
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const bool valid = has_depth(maps.D.at(u, v), maps.V.at(u, v));
        ASSERT_EQ(pyramid.inverse_depth(0).at(u, v), valid ? maps.D.at(u, v) : 0.0F);
        ASSERT_EQ(pyramid.variance(0).at(u, v), valid ? maps.V.at(u, v) : 0.0F);
      }
    }
    for (int l = 1; l < pyramid.num_levels(); ++l) {
      const Plane<float>& D = pyramid.inverse_depth(l - 1);
      const Plane<float>& V = pyramid.variance(l - 1);
      for (int v = 0; v < D.height() / 2; ++v) {
        for (int u = 0; u < D.width() / 2; ++u) {
          double n = 0.0, sum_w = 0.0, sum_wD = 0.0;
          for (int k = 0; k < 4; ++k) {
            const int x = 2 * u + k % 2;
            const int y = 2 * v + k / 2;
            if (!(V.at(x, y) > 0.0F)) continue;
            n += 1.0;
            sum_w += 1.0 / V.at(x, y);
            sum_wD += D.at(x, y) / V.at(x, y);
          }
          const float parent_D = pyramid.inverse_depth(l).at(u, v);
          const float parent_V = pyramid.variance(l).at(u, v);
          ASSERT_NEAR(parent_D, n > 0.0 ? sum_wD / sum_w : 0.0, 1e-6);
          ASSERT_NEAR(parent_V, n > 0.0 ? n / sum_w : 0.0, 1e-6 * parent_V);
        }
      }
    }
  }
}

TEST(DepthPyramid, EqualVariancesDoNotShrink) {
  const Plane<float> D = plane_of(4, 4, [](int u, int) { return 1.0 + 0.1 * u; });
  const Plane<float> V = plane_of(4, 4, [](int, int) { return 0.01; });
  const DepthPyramid pyramid(D.view(), V.view(), {{3, 1}});
  EXPECT_FLOAT_EQ(pyramid.variance(1).at(0, 0), 0.01F);
  EXPECT_FLOAT_EQ(pyramid.variance(2).at(0, 0), 0.01F);
  EXPECT_FLOAT_EQ(pyramid.inverse_depth(2).at(0, 0), 1.15F);
}

TEST(DepthPyramid, EdgesAreRejectedOnRequestOnly) {
  const Plane<float> D = plane_of(8, 4, [](int u, int) { return u < 3 ? 1.0 : 0.5; });
  const Plane<float> V = plane_of(8, 4, [](int, int) { return 0.01; });
  const DepthPyramid mixed(D.view(), V.view(), {{2, 1}});
  EXPECT_FLOAT_EQ(mixed.inverse_depth(1).at(1, 0), 0.75F);
  DepthPyramidOptions options{{2, 1}};
  options.max_depth_ratio = 1.5;
  const DepthPyramid clean(D.view(), V.view(), options);
  for (int u = 0; u < 4; ++u) {
    EXPECT_EQ(clean.variance(1).at(u, 1) > 0.0F, u != 1);
    EXPECT_EQ(clean.inverse_depth(1).at(u, 1), u == 0 ? 1.0F : (u == 1 ? 0.0F : 0.5F));
  }
  options.max_depth_ratio = 2.5;
  EXPECT_FLOAT_EQ(DepthPyramid(D.view(), V.view(), options).inverse_depth(1).at(1, 0), 0.75F);
}

TEST(DepthPyramid, ExtremeValuesGiveNoDepthInsteadOfInfinities) {
  for (const float tiny : {1e-45F, 1e-38F}) {
    const Plane<float> D = plane_of(2, 2, [](int, int) { return 1e30; });
    const Plane<float> V = plane_of(2, 2, [&](int, int) { return tiny; });
    const DepthPyramid pyramid(D.view(), V.view(), {{2, 1}});
    EXPECT_EQ(pyramid.inverse_depth(1).at(0, 0), 0.0F);
    EXPECT_EQ(pyramid.variance(1).at(0, 0), 0.0F);
  }
}

TEST(DepthPyramid, AdoptedMapsGiveTheSameLevelsWithoutACopy) {
  const Maps maps(37, 26);
  const DepthPyramid copied(maps.D.view(), maps.V.view());
  // level 0 is what the rule makes of the maps: adopting that must change nothing
  Plane<float> D = copied.inverse_depth(0);
  Plane<float> V = copied.variance(0);
  const float* memory = D.data();
  DepthPyramid adopted;
  adopted.adopt(D, V);
  EXPECT_EQ(adopted.inverse_depth(0).data(), memory);
  EXPECT_TRUE(D.empty());  // the pyramid had none to give back
  ASSERT_EQ(adopted.num_levels(), copied.num_levels());
  for (int l = 0; l < adopted.num_levels(); ++l) {
    for (int v = 0; v < adopted.variance(l).height(); ++v) {
      for (int u = 0; u < adopted.variance(l).width(); ++u) {
        EXPECT_EQ(adopted.inverse_depth(l).at(u, v), copied.inverse_depth(l).at(u, v));
        EXPECT_EQ(adopted.variance(l).at(u, v), copied.variance(l).at(u, v));
      }
    }
  }
  Plane<float> other(3, 3);
  EXPECT_THROW(adopted.adopt(other, V), ShapeError);
}

TEST(DepthPyramid, RefusesWhatCannotBe) {
  const Maps maps(8, 6);
  const Maps other(6, 8);
  EXPECT_THROW(DepthPyramid(maps.D.view(), other.V.view()), ShapeError);
  EXPECT_THROW(DepthPyramid(PlaneView<float>{}, PlaneView<float>{}), ShapeError);
  DepthPyramidOptions options;
  options.max_depth_ratio = 1.0;
  EXPECT_THROW(DepthPyramid(maps.D.view(), maps.V.view(), options), OptionsError);
  options.max_depth_ratio = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(DepthPyramid(maps.D.view(), maps.V.view(), options), OptionsError);
}

}  // namespace
}  // namespace raylign::test
