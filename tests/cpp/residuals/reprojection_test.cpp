// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/residuals/reprojection.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "raylign/geometry/se3.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign {
namespace {

using test::is_near;

struct State {
  Matrix4 T_cw;
  Vector3 intrinsics;
  Vector3 x;
  Vector2 observed;
};

State random_state(int index) {
  auto rng = test::make_rng("reprojection", index);
  State s;
  s.T_cw = se3_exp(rng.normal_vector<6>(0.8));
  s.intrinsics = Vector3(rng.uniform(200, 1500), rng.normal(0.1), rng.normal(0.02));
  const double side = index % 4 == 0 ? 1.0 : -1.0;  // every fourth point lies behind the camera
  const Vector3 p_c(rng.normal(1.0), rng.normal(1.0), side * rng.uniform(1.0, 20.0));
  s.x = (se3_inverse(s.T_cw) * p_c.homogeneous()).head<3>();
  s.observed = rng.normal_vector<2>(300.0);
  return s;
}

Vector2 residual(const Matrix4& T_cw,
                 const Vector3& intrinsics,
                 const Vector3& x,
                 const Vector2& observed) {
  Vector2 r;
  EXPECT_TRUE(reprojection_residual((T_cw * x.homogeneous()).head<3>(), intrinsics, observed, r));
  return r;
}

TEST(Reprojection, JacobiansAgreeWithNumericOnes) {
  for (int i = 0; i < 100; ++i) {
    const State s = random_state(i);
    const Vector3 p_c = (s.T_cw * s.x.homogeneous()).head<3>();
    Vector2 r;
    RowMajor<2, 3> J_p;
    RowMajor<2, 3> J_intrinsics;
    ASSERT_TRUE(reprojection_residual(p_c, s.intrinsics, s.observed, r, &J_p, &J_intrinsics));
    const auto of_pose = [&](const Vector6& xi) {
      return residual(se3_exp(xi) * s.T_cw, s.intrinsics, s.x, s.observed);
    };
    const auto of_intrinsics = [&](const Vector3& k) {
      return residual(s.T_cw, k, s.x, s.observed);
    };
    const auto of_point = [&](const Vector3& x) {
      return residual(s.T_cw, s.intrinsics, x, s.observed);
    };
    EXPECT_TRUE(is_near(pose_jacobian(J_p, p_c),
                        test::numeric_jacobian(of_pose, Vector6(Vector6::Zero()), 1e-2), 1e-8));
    EXPECT_TRUE(
        is_near(J_intrinsics, test::numeric_jacobian(of_intrinsics, s.intrinsics, 1e-1), 1e-8));
    EXPECT_TRUE(is_near(point_jacobian(J_p, s.T_cw.topLeftCorner<3, 3>()),
                        test::numeric_jacobian(of_point, s.x, 1e-2), 1e-8));
  }
}

// u = −f X/Z (1 + k1 r² + k2 r⁴), written out with numbers: a sign or an axis cannot slip through.
TEST(Reprojection, IsPredictedMinusObservedOnTheBalCamera) {
  Vector2 r;
  ASSERT_TRUE(reprojection_residual({1.0, 2.0, -4.0}, {100.0, 0.1, 0.01}, {20.0, 60.0}, r));
  const double r2 = 0.0625 + 0.25;
  const double distortion = 1.0 + 0.1 * r2 + 0.01 * r2 * r2;
  EXPECT_DOUBLE_EQ(r.x(), 100.0 * distortion * 0.25 - 20.0);
  EXPECT_DOUBLE_EQ(r.y(), 100.0 * distortion * 0.5 - 60.0);
}

TEST(Reprojection, DoesNotDependOnTheScaleOfTheHomogeneousPoint) {
  Vector2 a;
  Vector2 b;
  ASSERT_TRUE(reprojection_residual({1.0, 2.0, -4.0}, {100.0, 0.1, 0.01}, {0.0, 0.0}, a));
  ASSERT_TRUE(reprojection_residual({-0.5, -1.0, 2.0}, {100.0, 0.1, 0.01}, {0.0, 0.0}, b));
  EXPECT_TRUE(is_near(a, b, 1e-15));
}

TEST(Reprojection, RefusesAPointInTheCameraPlane) {
  Vector2 r;
  EXPECT_FALSE(reprojection_residual({1.0, 1.0, 0.0}, {100.0, 0.0, 0.0}, {0.0, 0.0}, r));
  EXPECT_FALSE(reprojection_residual({1.0, NAN, -1.0}, {100.0, 0.0, 0.0}, {0.0, 0.0}, r));
}

}  // namespace
}  // namespace raylign
