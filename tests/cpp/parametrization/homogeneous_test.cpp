// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/parametrization/homogeneous.h"

#include <gtest/gtest.h>

#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign {
namespace {

// Anywhere on the sphere, and where the Householder vector changes its form.
std::vector<Vector4> states() {
  auto rng = test::make_rng("sphere");
  std::vector<Vector4> x = {Vector4::UnitW(),
                            -Vector4::UnitW(),
                            Vector4::UnitX(),
                            Vector4(1e-9, 0.0, 0.0, 1.0),
                            Vector4(1e-9, 0.0, 0.0, -1.0),
                            Vector4(0.6, -0.8, 0.0, -1e-12)};
  for (int i = 0; i < 50; ++i) x.push_back(rng.unit_vector<4>());
  return x;
}

TEST(SphereTangent, PlusOfZeroIsThePointItself) {
  for (const Vector4& x : states()) {
    EXPECT_TRUE(test::is_near(SphereTangent(x).plus(Vector3::Zero()), x, 2e-8)) << x.transpose();
  }
}

TEST(SphereTangent, StaysOnTheSphere) {
  auto rng = test::make_rng("sphere steps");
  for (const Vector4& x : states()) {
    EXPECT_NEAR(SphereTangent(x).plus(rng.normal_vector<3>(2.0)).norm(), 1.0, 1e-14);
  }
}

TEST(SphereTangent, BasisIsTheDerivativeOfPlus) {
  for (const Vector4& x : states()) {
    const SphereTangent tangent(x);
    const auto moved = [&](const Vector3& delta) { return tangent.plus(delta); };
    EXPECT_TRUE(test::is_near(tangent.basis(),
                              test::numeric_jacobian(moved, Vector3(Vector3::Zero())), 1e-9));
    EXPECT_TRUE(test::is_near(4.0 * tangent.basis().transpose() * tangent.basis(),
                              Matrix3::Identity(), 1e-14));
  }
}

TEST(HomogeneousFrame, GoesToTheWorldAndBack) {
  const HomogeneousFrame frame{{1.0, -2.0, 0.5}, 3.0};
  auto rng = test::make_rng("homogeneous frame");
  for (const double distance : {1e-3, 1.0, 1e6}) {
    const Vector3 X = distance * rng.normal_vector<3>();
    EXPECT_NEAR(frame.from_world(X).norm(), 1.0, 1e-15);
    EXPECT_TRUE(test::is_near(frame.to_world(frame.from_world(X)), X, 1e-9));
  }
}

TEST(HomogeneousFrame, WritesPointsAtInfinityFarAway) {
  const HomogeneousFrame frame{{1.0, -2.0, 0.5}, 3.0};
  EXPECT_NEAR(frame.to_world({0.0, 0.6, 0.8, 0.0}).z(), 2.4e12, 1.0);
  EXPECT_LT(frame.to_world({0.0, 0.6, 0.8, -1e-15}).z(), 0.0);
}

}  // namespace
}  // namespace raylign
