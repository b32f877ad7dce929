// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/polynomial_distortion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raylign/base/error.h"
#include "raylign/camera/bal.h"
#include "raylign/camera/undistort.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"

namespace raylign::test {
namespace {

const double kInfinity = std::numeric_limits<double>::infinity();

PolynomialDistortion radial(double k1, double k2, double k3) { return {k1, k2, 0.0, 0.0, k3}; }

TEST(PolynomialDistortion, MaxRadiusInClosedCases) {
  EXPECT_EQ(radial(0.0, 0.0, 0.0).max_radius_squared(), kInfinity);
  EXPECT_EQ(radial(0.3, 0.1, 0.2).max_radius_squared(), kInfinity);
  // 1 + 3 k1 x = 0, 1 + 5 k2 x² = 0, 1 + 7 k3 x³ = 0.
  EXPECT_NEAR(radial(-0.25, 0.0, 0.0).max_radius_squared(), 4.0 / 3.0, 1e-15);
  EXPECT_NEAR(radial(0.0, -0.2, 0.0).max_radius_squared(), 1.0, 1e-15);
  EXPECT_NEAR(radial(0.0, 0.0, -1.0 / 7.0).max_radius_squared(), 1.0, 1e-15);
  // (1 − x)(1 − x/2): the first root, though the slope is positive again behind the second.
  EXPECT_NEAR(radial(-0.5, 0.1, 0.0).max_radius_squared(), 1.0, 1e-14);
  // (1 − x)(1 − x/2)(1 − x/4): the first of three.
  EXPECT_NEAR(radial(-7.0 / 12.0, 7.0 / 40.0, -1.0 / 56.0).max_radius_squared(), 1.0, 1e-14);
}

TEST(PolynomialDistortion, MaxRadiusIsTheFirstSignChangeOfTheSlope) {
  for (int i = 0; i < 300; ++i) {
    NamedRng rng = make_rng("max_radius", i);
    const PolynomialDistortion d = radial(rng.normal(), rng.normal(), rng.normal());
    const auto slope = [&](double x) {
      return 1.0 + 3.0 * d.k1 * x + 5.0 * d.k2 * x * x + 7.0 * d.k3 * x * x * x;
    };
    const double limit = d.max_radius_squared();
    const double scan_end = std::isfinite(limit) ? limit : 100.0;
    for (int k = 0; k < 1000; ++k) ASSERT_GE(slope(scan_end * k / 1000.0), -1e-9) << i;
    if (std::isfinite(limit)) {
      ASSERT_NEAR(slope(limit), 0.0, 1e-9 * (1.0 + limit * limit * limit)) << i;
    }
  }
}

// Near the fold plain Newton jumps to the wrong branch; a returned ray must be the one that was
// imaged.
TEST(PolynomialDistortion, UndistortFindsTheBranchOfTheCentre) {
  for (int i = 0; i < 5000; ++i) {
    NamedRng rng = make_rng("undistort", i);
    const PolynomialDistortion d = radial(rng.normal(), rng.normal(), rng.normal());
    const double limit = std::min(d.max_radius_squared(), 4.0);
    const Vector2 p = rng.uniform(0.0, 0.999) * std::sqrt(limit) * rng.unit_vector<2>();
    Vector2 found;
    RowMajor<2, 2> J_p;
    ASSERT_TRUE(d.undistort(d.distort(p), d.max_radius_squared(), found, J_p)) << i;
    EXPECT_TRUE(is_near(found, p, 1e-9)) << i;
  }
}

TEST(PolynomialDistortion, BeyondTheFoldIsRefused) {
  const PolynomialDistortion d = radial(-0.25, 0.0, 0.0);
  const double r = std::sqrt(d.max_radius_squared());
  const double largest = r * (1.0 - 0.25 * r * r);
  Vector2 p;
  RowMajor<2, 2> J_p;
  EXPECT_TRUE(d.undistort(Vector2(0.9999 * largest, 0.0), r * r, p, J_p));
  EXPECT_FALSE(d.undistort(Vector2(1.0001 * largest, 0.0), r * r, p, J_p));
  EXPECT_FALSE(d.undistort(Vector2(100.0, 100.0), r * r, p, J_p));
  Vector3 bearing;
  EXPECT_FALSE(BalCamera(1.0, -0.25, 0.0).unproject(Vector2(1.0001 * largest, 0.0), bearing));
}

// r (1 − r²/2 + r⁴/10) rises to 0.6 at r = 1, falls, and rises again behind r = √2: a pixel at 0.9
// has a solution there, but no ray of the real lens.
TEST(PolynomialDistortion, TheOuterBranchIsNotTaken) {
  const PolynomialDistortion d = radial(-0.5, 0.1, 0.0);
  Vector2 p;
  RowMajor<2, 2> J_p;
  for (const double target : {0.61, 0.7, 0.9, 1.2, 5.0}) {
    EXPECT_FALSE(d.undistort(Vector2(target, 0.0), d.max_radius_squared(), p, J_p)) << target;
  }
  EXPECT_TRUE(d.undistort(Vector2(0.59, 0.0), d.max_radius_squared(), p, J_p));
}

TEST(PolynomialDistortion, NonFiniteParametersTerminate) {
  for (const double bad : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    Vector2 p;
    RowMajor<2, 2> J_p;
    const PolynomialDistortion d = radial(bad, 0.1, bad);
    EXPECT_FALSE(d.undistort(Vector2(0.1, 0.1), d.max_radius_squared(), p, J_p));
  }
}

TEST(RadtanCamera, RefusesPointsThatFoldBack) {
  const RadtanCamera camera({100.0, 100.0, 0.0, 0.0}, radial(-0.25, 0.0, 0.0));
  Vector2 uv;
  EXPECT_TRUE(camera.project(Vector3(1.15, 0.0, 1.0), uv));
  EXPECT_FALSE(camera.project(Vector3(1.16, 0.0, 1.0), uv));  // r² > 4/3
}

TEST(UndistortMap, SendsEachPixelWhereItsRayIsImaged) {
  const RadtanCamera camera({200.0, 210.0, 80.0, 60.0}, {-0.3, 0.1, 0.001, -0.002, 0.0});
  Matrix3 K_new = PinholeCamera(150.0, 155.0, 79.0, 61.0).matrix();
  K_new(0, 1) = 3.0;  // skew
  const UndistortMap map = undistort_map(camera, K_new, 160, 120);
  ASSERT_EQ(map.map_x.rows(), 120);
  ASSERT_EQ(map.map_x.cols(), 160);
  for (const auto& [u, v] : {std::pair(0, 0), std::pair(159, 119), std::pair(37, 90)}) {
    const double y = (v - 61.0) / 155.0;
    const double x = (u - 79.0 - 3.0 * y) / 150.0;
    Vector2 uv;
    ASSERT_TRUE(camera.project(Vector3(x, y, 1.0), uv));
    EXPECT_FLOAT_EQ(map.map_x(v, u), static_cast<float>(uv.x()));
    EXPECT_FLOAT_EQ(map.map_y(v, u), static_cast<float>(uv.y()));
  }
}

TEST(UndistortMap, PixelsWithoutImageAreOutside) {
  const RadtanCamera camera({100.0, 100.0, 50.0, 50.0}, radial(-0.25, 0.0, 0.0));
  const Matrix3 K_new = PinholeCamera(10.0, 10.0, 50.0, 50.0).matrix();
  const UndistortMap map = undistort_map(camera, K_new, 101, 101);
  EXPECT_EQ(map.map_x(0, 0), UndistortMap::kOutside);
  EXPECT_EQ(map.map_y(0, 0), UndistortMap::kOutside);
  EXPECT_FLOAT_EQ(map.map_x(50, 50), 50.0F);
}

TEST(UndistortMap, IdentityForAPinholeAndItself) {
  const PinholeCamera camera(100.0, 90.0, 12.0, 7.0);
  const UndistortMap map = undistort_map(camera, camera.matrix(), 24, 16);
  EXPECT_FLOAT_EQ(map.map_x(3, 20), 20.0F);
  EXPECT_FLOAT_EQ(map.map_y(3, 20), 3.0F);
}

TEST(UndistortMap, RefusesBadInput) {
  const PinholeCamera camera(100.0, 90.0, 12.0, 7.0);
  EXPECT_THROW(undistort_map(camera, camera.matrix(), 0, 5), ShapeError);
  EXPECT_THROW(undistort_map(camera, camera.matrix(), 5, -1), ShapeError);
  EXPECT_THROW(undistort_map(camera, Matrix3::Zero(), 5, 5), OptionsError);
  EXPECT_THROW(undistort_map(camera, Matrix3::Constant(kInfinity), 5, 5), OptionsError);
}

}  // namespace
}  // namespace raylign::test
