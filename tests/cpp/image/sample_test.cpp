// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/sample.h"

#include <gtest/gtest.h>

#include <limits>

#include "image/images.h"
#include "raylign/base/eigen.h"
#include "raylign/image/bspline.h"
#include "support/numeric_jacobian.h"

namespace raylign::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Points inside a 23 x 17 image; the margin to the next pixel is at least 0.1 px in `u` and `v`.
std::vector<Vector2> points_between_pixels() {
  std::vector<Vector2> points;
  for (int v = 0; v < 16; ++v) {
    for (int u = 0; u < 22; ++u) {
      points.emplace_back(u + 0.1 + 0.8 * ((u * 7 + v * 3) % 11) / 10.0,
                          v + 0.1 + 0.8 * ((u * 5 + v * 9) % 13) / 12.0);
    }
  }
  return points;
}

template <typename F>
void expect_exact_gradient(const F& sample, const std::vector<Vector2>& points, double step) {
  const auto value = [&](const Vector2& p) {
    Sample<double> s{};
    EXPECT_TRUE(sample(p.x(), p.y(), s));
    return Eigen::Matrix<double, 1, 1>(s.value);
  };
  for (const Vector2& p : points) {
    Sample<double> s{};
    ASSERT_TRUE(sample(p.x(), p.y(), s));
    const Eigen::Matrix<double, 1, 2> numeric = numeric_jacobian(value, p, step);
    ASSERT_NEAR(s.du, numeric(0), 1e-6) << p.transpose();
    ASSERT_NEAR(s.dv, numeric(1), 1e-6) << p.transpose();
  }
}

TEST(SampleBilinear, GradientIsThatOfTheInterpolant) {
  const Noise<float> noise(23, 17);
  expect_exact_gradient([&](double u, double v,
                            Sample<double>& s) { return sample_bilinear(noise.plane(), u, v, s); },
                        points_between_pixels(), 0.05);
}

TEST(SampleBilinear, TakesPixelsAndBilinearFunctionsExactly) {
  const auto f = [](double u, double v) { return 3.0 + 2.0 * u - v + 0.5 * u * v; };
  const Plane<float> image = plane_of(23, 17, f);
  std::vector<Vector2> points = points_between_pixels();
  for (int v = 0; v < 17; ++v) {
    for (int u = 0; u < 23; ++u) points.emplace_back(u, v);  // the last row and column, too
  }
  for (const Vector2& p : points) {
    Sample<double> s{};
    ASSERT_TRUE(sample_bilinear(image.view(), p.x(), p.y(), s));
    ASSERT_NEAR(s.value, f(p.x(), p.y()), 1e-12);
    ASSERT_NEAR(s.du, 2.0 + 0.5 * p.y(), 1e-12);
    ASSERT_NEAR(s.dv, -1.0 + 0.5 * p.x(), 1e-12);
  }
}

TEST(SampleBilinear, FloatIsDoubleToRounding) {
  const Noise<float> noise(23, 17);
  for (const Vector2& p : points_between_pixels()) {
    Sample<double> wide{};
    Sample<float> narrow{};
    ASSERT_TRUE(sample_bilinear(noise.plane(), p.x(), p.y(), wide));
    ASSERT_TRUE(sample_bilinear(noise.plane(), float(p.x()), float(p.y()), narrow));
    ASSERT_NEAR(narrow.value, wide.value, 2e-3);
    ASSERT_NEAR(narrow.du, wide.du, 2e-3);
  }
}

TEST(SampleBilinear, GradientImageInterpolatesItsCells) {
  const Noise<float> noise(23, 17);
  GradientImage cells;
  make_gradient_image(noise.plane(), cells);
  const Plane<float> du = plane_of(23, 17, [&](int u, int v) { return cells.at(u, v).du; });
  const Plane<float> dv = plane_of(23, 17, [&](int u, int v) { return cells.at(u, v).dv; });
  for (const Vector2& p : points_between_pixels()) {
    Sample<double> all{};
    Sample<double> one{};
    ASSERT_TRUE(sample_bilinear(cells.view(), p.x(), p.y(), all));
    sample_bilinear(noise.plane(), p.x(), p.y(), one);
    ASSERT_NEAR(all.value, one.value, 1e-10);
    sample_bilinear(du.view(), p.x(), p.y(), one);
    ASSERT_NEAR(all.du, one.value, 1e-10);
    sample_bilinear(dv.view(), p.x(), p.y(), one);
    ASSERT_NEAR(all.dv, one.value, 1e-10);
  }
}

TEST(Samplers, ImageEndsAtTheCentresOfItsBorderPixels) {
  const Noise<float> noise(23, 17);
  GradientImage cells;
  make_gradient_image(noise.plane(), cells);
  const BSplineImage spline(noise.plane());
  const auto all = [&](double u, double v) {
    Sample<double> s{};
    const bool valid = sample_bilinear(noise.plane(), u, v, s);
    EXPECT_EQ(sample_bilinear(cells.view(), u, v, s), valid);
    EXPECT_EQ(spline.sample(u, v, s), valid);
    return valid;
  };
  for (const auto& [u, v] : std::vector<std::pair<double, double>>{
           {0.0, 0.0}, {22.0, 0.0}, {0.0, 16.0}, {22.0, 16.0}, {-0.0, 3.5}}) {
    EXPECT_TRUE(all(u, v)) << u << " " << v;
  }
  for (const double bad : {-1e-9, -1.0, 22.0 + 1e-9, 1e30, kNan, kInfinity, -kInfinity}) {
    EXPECT_FALSE(all(bad, 5.0)) << bad;
  }
  for (const double bad : {-1e-9, 16.0 + 1e-9, -1e30, kNan, kInfinity}) {
    EXPECT_FALSE(all(5.0, bad)) << bad;
  }
}

TEST(Samplers, OnePixelHasOnePoint) {
  const Plane<float> image = plane_of(1, 1, [](int, int) { return 42.0; });
  GradientImage cells;
  make_gradient_image(image.view(), cells);
  const BSplineImage spline(image.view());
  Sample<double> s{};
  ASSERT_TRUE(sample_bilinear(image.view(), 0.0, 0.0, s));
  EXPECT_EQ(s.value, 42.0);
  ASSERT_TRUE(sample_bilinear(cells.view(), 0.0, 0.0, s));
  EXPECT_EQ(s.value, 42.0);
  ASSERT_TRUE(spline.sample(0.0, 0.0, s));
  EXPECT_NEAR(s.value, 42.0, 1e-5);
  EXPECT_NEAR(s.du, 0.0, 1e-5);
  EXPECT_FALSE(sample_bilinear(image.view(), 0.5, 0.0, s));
}

TEST(BSplineImage, GradientIsExactEverywhere) {
  const Noise<float> noise(23, 17);
  const BSplineImage spline(noise.plane());
  std::vector<Vector2> points = points_between_pixels();
  expect_exact_gradient(
      [&](double u, double v, Sample<double>& s) { return spline.sample(u, v, s); }, points, 0.05);
  // At the pixels the third derivative jumps: a small step.
  points.clear();
  for (int u = 1; u < 22; ++u) points.emplace_back(u, 1 + u % 15);
  expect_exact_gradient(
      [&](double u, double v, Sample<double>& s) { return spline.sample(u, v, s); }, points, 1e-3);
}

TEST(BSplineImage, GoesThroughThePixels) {
  for (const auto& [width, height] : awkward_sizes()) {
    const Noise<float> noise(width, height);
    const BSplineImage spline(noise.plane());
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        Sample<double> s{};
        ASSERT_TRUE(spline.sample(double(u), double(v), s));
        ASSERT_NEAR(s.value, noise.at(u, v), 3e-4)
            << width << "x" << height << " " << u << " " << v;
      }
    }
  }
}

// Away from the border, whose mirroring bends every function but a constant.
TEST(BSplineImage, ReproducesCubicsInTheInterior) {
  const auto f = [](double u, double v) {
    const double x = (u - 30.0) / 30.0;
    const double y = (v - 30.0) / 30.0;
    return 40.0 * x * x * x - 30.0 * x * x * y + 20.0 * x * y * y * y + 10.0 * x - 5.0 * y + 90.0;
  };
  const BSplineImage spline(plane_of(61, 61, f).view());
  for (double v = 18.0; v <= 42.0; v += 0.7) {
    for (double u = 18.0; u <= 42.0; u += 0.9) {
      Sample<double> s{};
      ASSERT_TRUE(spline.sample(u, v, s));
      ASSERT_NEAR(s.value, f(u, v), 2e-4);
      ASSERT_NEAR(s.du, (f(u + 1e-4, v) - f(u - 1e-4, v)) / 2e-4, 2e-4);
    }
  }
}

TEST(BSplineImage, MirrorsAtTheBorderPixels) {
  const Noise<float> noise(9, 6);
  const Plane<float> mirrored = plane_of(9 + 16, 6, [&](int u, int v) {
    const int x = u < 8 ? 8 - u : (u > 16 ? 24 - u : u - 8);
    return noise.at(x, v);
  });
  const BSplineImage spline(noise.plane());
  const BSplineImage wide(mirrored.view());
  for (double u = 0.0; u <= 8.0; u += 0.37) {
    Sample<double> s{};
    Sample<double> expected{};
    ASSERT_TRUE(spline.sample(u, 2.3, s));
    ASSERT_TRUE(wide.sample(u + 8.0, 2.3, expected));
    ASSERT_NEAR(s.value, expected.value, 2e-2);  // the far ends of `wide` still shine through
    ASSERT_NEAR(s.du, expected.du, 2e-2);
  }
}

TEST(BSplineImage, MissingDataStaysLocal) {
  Plane<float> image = plane_of(23, 17, [](int u, int v) { return 5.0 * u + 3.0 * v; });
  image.at(10, 8) = static_cast<float>(kNan);
  image.at(0, 0) = static_cast<float>(kInfinity);
  BSplineImage spline(image.view());
  for (double v = 0.5; v < 16.0; v += 1.0) {
    for (double u = 0.5; u < 22.0; u += 1.0) {
      Sample<double> s{};
      ASSERT_TRUE(spline.sample(u, v, s));
      const bool near_first = std::abs(u - 10.0) < 2.0 && std::abs(v - 8.0) < 2.0;
      const bool near_second = u < 2.0 && v < 2.0;
      ASSERT_EQ(!std::isfinite(s.value), near_first || near_second) << u << " " << v;
    }
  }
  Sample<double> s{};
  spline.sample(12.0, 9.0, s);
  EXPECT_NEAR(s.value, 87.0, 1e-3);  // still goes through the others
  const Noise<float> clean(23, 17);
  spline.assign(clean.plane());  // the same memory again
  ASSERT_TRUE(spline.sample(10.0, 8.0, s));
  EXPECT_NEAR(s.value, clean.at(10, 8), 3e-4);
}

}  // namespace
}  // namespace raylign::test
