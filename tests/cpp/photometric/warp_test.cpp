// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/warp.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "raylign/geometry/se3.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign::photometric {
namespace {

using test::make_rng;

const Vector4 kHost(300.0, 310.0, 160.0, 120.0);
const Vector4 kTarget(280.0, 285.0, 150.0, 125.0);

// Pixel of the host → ray → point of the plane n · X = d → pixel of the target.
Vector2 homography(const Matrix4& T, const Vector3& n, double d, const Vector2& uv) {
  const Vector3 ray((uv.x() - kHost[2]) / kHost[0], (uv.y() - kHost[3]) / kHost[1], 1.0);
  const Vector3 X = ray * (d / n.dot(ray));
  const Vector3 q = T.topLeftCorner<3, 3>() * X + T.topRightCorner<3, 1>();
  return {kTarget[0] * q.x() / q.z() + kTarget[2], kTarget[1] * q.y() / q.z() + kTarget[3]};
}

TEST(PlaneWarpTest, IsTheDerivativeOfTheHomography) {
  auto rng = make_rng("plane warp");
  for (int i = 0; i < 50; ++i) {
    const Vector2 uv(rng.uniform(20, 300), rng.uniform(20, 220));
    const Vector3 ray((uv.x() - kHost[2]) / kHost[0], (uv.y() - kHost[3]) / kHost[1], 1.0);
    const Vector3 n = (rng.normal_vector<3>(0.3) - Vector3::UnitZ()).normalized();
    const double depth = rng.uniform(1.0, 4.0);
    const Matrix4 T = se3_exp(Vector6(rng.normal_vector<6>(0.15)));
    const PlaneWarp warp = plane_warp(T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>(), ray, depth,
                                      n, kHost, kTarget);
    if (!warp.is_valid) continue;
    const double d = depth * n.dot(ray);
    const auto f = [&](const Vector2& x) { return homography(T, n, d, x); };
    const Eigen::Matrix2d expected = test::numeric_jacobian(f, uv, 1.0);
    EXPECT_LT((warp.A - expected).norm(), 1e-7 * expected.norm()) << i;
  }
}

TEST(PlaneWarpTest, TwiceAsNearIsTwiceAsLarge) {
  const PlaneWarp warp = plane_warp(Matrix3::Identity(), {0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}, 2.0,
                                    Vector3::UnitZ(), kHost, kHost);
  ASSERT_TRUE(warp.is_valid);
  EXPECT_NEAR(warp.scale(), 2.0, 1e-12);
  EXPECT_NEAR(warp.cos_view, 1.0, 1e-12);
}

TEST(PlaneWarpTest, RefusesTheOtherSideAndWhatIsBehind) {
  const Vector3 ray(0.0, 0.0, 1.0);
  // Beyond the plane, looking back at it.
  Matrix3 turn = Matrix3::Identity();
  turn(0, 0) = turn(2, 2) = -1.0;
  EXPECT_FALSE(
      plane_warp(turn, {0.0, 0.0, 4.0}, ray, 2.0, Vector3::UnitZ(), kHost, kHost).is_valid);
  EXPECT_FALSE(
      plane_warp(Matrix3::Identity(), {0.0, 0.0, -3.0}, ray, 2.0, Vector3::UnitZ(), kHost, kHost)
          .is_valid);
  EXPECT_FALSE(
      plane_warp(Matrix3::Identity(), Vector3::Zero(), ray, -1.0, Vector3::UnitZ(), kHost, kHost)
          .is_valid);
}

}  // namespace
}  // namespace raylign::photometric
