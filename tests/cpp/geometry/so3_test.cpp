// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/so3.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/stumpff.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"

namespace raylign::test {
namespace {

const double kPi = std::acos(-1.0);

TEST(So3, HatIsTheCrossProduct) {
  const Vector3 a(1.0, -2.0, 3.0);
  const Vector3 b(0.5, 4.0, -1.5);
  EXPECT_TRUE(is_near(so3_hat(a) * b, a.cross(b), 1e-15));
}

TEST(So3, PositiveRotationAboutZTurnsXIntoY) {
  const Matrix3 R = so3_exp(Vector3(0.0, 0.0, kPi / 2.0));
  EXPECT_TRUE(is_near(R * Vector3::UnitX(), Vector3::UnitY(), 1e-15));
}

// A logarithm through acos(trace) would lose half of the digits here.
TEST(So3, SmallAnglesKeepAllDigits) {
  for (int exponent = -300; exponent <= -2; ++exponent) {
    NamedRng rng = make_rng("so3_small", exponent + 300);
    const Vector3 omega = std::pow(10.0, exponent) * rng.unit_vector<3>();
    EXPECT_TRUE(is_relatively_near(so3_log(so3_exp(omega)), omega, 1e-14)) << exponent;
    EXPECT_TRUE(is_relatively_near(quaternion_log(quaternion_exp(omega)), omega, 1e-14))
        << exponent;
    EXPECT_TRUE(is_relatively_near(so3_vee(so3_exp(omega)), omega, 1e-3)) << exponent;
  }
}

TEST(So3, LogNearPi) {
  for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    for (int i = 0; i < 20; ++i) {
      NamedRng rng = make_rng("so3_near_pi", i);
      const Vector3 omega = (kPi - gap) * rng.unit_vector<3>();
      const Vector3 back = so3_log(so3_exp(omega));
      if (gap > 1e-14) {
        EXPECT_TRUE(is_near(back, omega, 1e-14)) << gap;
      }
      EXPECT_TRUE(is_near(so3_exp(back), so3_exp(omega), 1e-14)) << gap;
      EXPECT_LE(back.norm(), kPi + 1e-15);
    }
  }
}

TEST(So3, LogAtPi) {
  for (int i = 0; i < 50; ++i) {
    NamedRng rng = make_rng("so3_at_pi", i);
    const Vector3 axis = i < 3 ? Vector3(Vector3::Unit(i)) : rng.unit_vector<3>();
    const Matrix3 R = 2.0 * axis * axis.transpose() - Matrix3::Identity();
    const Vector3 omega = so3_log(R);
    EXPECT_NEAR(omega.norm(), kPi, 1e-14);
    EXPECT_NEAR(std::abs(omega.normalized().dot(axis)), 1.0, 1e-14);
    EXPECT_TRUE(is_near(so3_exp(omega), R, 1e-14));
  }
}

TEST(So3, LogOfAlmostRotationsIsClose) {
  for (int i = 0; i < 20; ++i) {
    NamedRng rng = make_rng("so3_almost", i);
    const Vector3 omega = rng.uniform(0.0, 3.0) * rng.unit_vector<3>();
    Matrix3 noise;
    for (int k = 0; k < 9; ++k) noise.data()[k] = rng.normal(1e-7);
    EXPECT_TRUE(is_near(so3_log(so3_exp(omega) + noise), omega, 1e-5));
    EXPECT_TRUE(is_near(so3_log(1.001 * so3_exp(omega)), omega, 1e-2));
  }
}

TEST(So3, LargeAnglesWrap) {
  const Vector3 axis = Vector3(1.0, 2.0, 2.0) / 3.0;
  EXPECT_TRUE(is_near(so3_log(so3_exp((2.0 * kPi + 0.5) * axis)), 0.5 * axis, 1e-14));
  EXPECT_TRUE(is_near(so3_log(so3_exp((2.0 * kPi - 0.5) * axis)), -0.5 * axis, 1e-14));
}

TEST(So3, ExpStaysOrthonormal) {
  for (int i = 0; i < 100; ++i) {
    NamedRng rng = make_rng("so3_orthonormal", i);
    const Matrix3 R = so3_exp(rng.normal_vector<3>(5.0));
    EXPECT_TRUE(is_near(R.transpose() * R, Matrix3::Identity(), 2e-15));
    EXPECT_NEAR(R.determinant(), 1.0, 2e-15);
  }
}

TEST(So3, ExpAndLeftJacobianAreTheTwoFunctions) {
  NamedRng rng = make_rng("so3_exp_and_left_jacobian");
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-8, 1e-4, 0.01, 0.5, 3.0, kPi, 6.0}) {
    const Vector3 omega = angle * rng.unit_vector<3>();
    Matrix3 J_left;
    EXPECT_EQ(so3_exp_and_left_jacobian(omega, J_left), so3_exp(omega)) << angle;
    EXPECT_TRUE(is_near(J_left, so3_left_jacobian(omega), 1e-15)) << angle;
  }
}

TEST(Quaternion, MatchesTheMatrixExponential) {
  for (int i = 0; i < 50; ++i) {
    NamedRng rng = make_rng("quaternion_exp", i);
    const Vector3 omega = rng.uniform(0.0, 2.0 * kPi) * rng.unit_vector<3>();
    const Quaternion q = quaternion_exp(omega);
    EXPECT_NEAR(q.norm(), 1.0, 4e-16);
    EXPECT_TRUE(is_near(quaternion_to_matrix(q), so3_exp(omega), 2e-15));
    EXPECT_TRUE(is_near(quaternion_to_matrix(Quaternion(3.0 * q.coeffs())), so3_exp(omega), 2e-15));
    EXPECT_TRUE(is_near(quaternion_log(q), so3_log(so3_exp(omega)), 1e-14));
    EXPECT_TRUE(is_near(quaternion_log(Quaternion(-2.0 * q.coeffs())), quaternion_log(q), 1e-14));
  }
}

TEST(Quaternion, MemoryOrderIsXyzw) {
  const Quaternion q = quaternion_exp(Vector3(0.2, 0.0, 0.0));
  EXPECT_TRUE(is_near(q.coeffs(), Vector4(std::sin(0.1), 0.0, 0.0, std::cos(0.1)), 1e-16));
}

// Each of Shepperd's four cases has its largest component, and w >= 0 picks one of ±q.
TEST(Quaternion, FromMatrixInAllFourCases) {
  for (int largest = 0; largest < 4; ++largest) {
    for (const double value : {2.0, -2.0}) {
      Vector4 xyzw(0.1, -0.2, 0.3, 0.25);
      xyzw[largest] = value;
      xyzw.normalize();
      const Vector4 found = quaternion_from_matrix(quaternion_to_matrix(Quaternion(xyzw))).coeffs();
      EXPECT_TRUE(is_near(found, xyzw[3] < 0.0 ? Vector4(-xyzw) : xyzw, 1e-15)) << largest;
    }
  }
}

long double stumpff_series(int k, long double x) {
  long double term = 1.0L;
  for (int i = 2; i <= k; ++i) term /= i;
  long double sum = term;
  for (int n = k + 2; n < 120; n += 2) {
    term *= -x / (static_cast<long double>(n) * (n - 1));
    sum += term;
  }
  return sum;
}

TEST(Stumpff, AgreesWithTheSeriesInLongDouble) {
  for (const double x : {0.0, 1e-300, 1e-20, 1e-8, 1e-3, 0.1, 1.0, 3.0, 3.999999, 4.0, 4.1, 6.0,
                         9.0, 9.8, 12.0, 20.0, 30.0}) {
    const Stumpff c = stumpff(x);
    EXPECT_NEAR(c.c1, static_cast<double>(stumpff_series(1, x)), 4e-16) << x;
    EXPECT_NEAR(c.c2 / static_cast<double>(stumpff_series(2, x)), 1.0, 2e-15) << x;
    EXPECT_NEAR(c.c3 / static_cast<double>(stumpff_series(3, x)), 1.0, 2e-15) << x;
    EXPECT_NEAR(c.c4 / static_cast<double>(stumpff_series(4, x)), 1.0, 2e-15) << x;
    EXPECT_NEAR(c.c5 / static_cast<double>(stumpff_series(5, x)), 1.0, 2e-15) << x;
  }
}

}  // namespace
}  // namespace raylign::test
