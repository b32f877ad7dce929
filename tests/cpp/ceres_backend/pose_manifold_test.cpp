// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/pose_manifold.h"

#include <gtest/gtest.h>

#include "raylign/ceres_backend/pose_blocks.h"
#include "raylign/geometry/se3.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign::ceres_backend {
namespace {

using test::is_near;

Vector7 random_pose(test::NamedRng& rng) {
  Vector7 x;
  x << rng.unit_vector<4>(), rng.normal_vector<3>(3.0);
  return x;
}

Eigen::VectorXd random_tangent(test::NamedRng& rng, int size) {
  Eigen::VectorXd delta(size);
  for (double& d : delta) d = rng.normal(0.3);
  return delta;
}

Vector7 plus(const PoseManifold& manifold, const Vector7& x, const Eigen::VectorXd& delta) {
  Vector7 y;
  EXPECT_TRUE(manifold.Plus(x.data(), delta.data(), y.data()));
  return y;
}

Eigen::VectorXd minus(const PoseManifold& manifold, const Vector7& y, const Vector7& x) {
  Eigen::VectorXd delta(manifold.TangentSize());
  EXPECT_TRUE(manifold.Minus(y.data(), x.data(), delta.data()));
  return delta;
}

Eigen::MatrixXd plus_jacobian(const PoseManifold& manifold, const Vector7& x) {
  Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::RowMajor> J(7, manifold.TangentSize());
  EXPECT_TRUE(manifold.PlusJacobian(x.data(), J.data()));
  return J;
}

Eigen::MatrixXd minus_jacobian(const PoseManifold& manifold, const Vector7& x) {
  Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> J(manifold.TangentSize(), 7);
  EXPECT_TRUE(manifold.MinusJacobian(x.data(), J.data()));
  return J;
}

Matrix4 to_matrix(const Vector7& x) {
  const QuaternionPose pose(x.data());
  Matrix4 T = Matrix4::Identity();
  T.topLeftCorner<3, 3>() = pose.R_cw;
  T.topRightCorner<3, 1>() = pose.t_cw;
  return T;
}

class PoseManifoldAxioms
    : public testing::TestWithParam<std::tuple<TranslationUpdate, std::array<bool, 4>>> {
 protected:
  PoseManifold manifold() const {
    const auto& [update, held] = GetParam();
    return PoseManifold(update, {{held[0], held[1], held[2]}, held[3]});
  }
};

TEST_P(PoseManifoldAxioms, PlusZeroIsIdentityBitByBit) {
  auto rng = test::make_rng("plus zero");
  const Vector7 x = random_pose(rng);
  EXPECT_EQ(plus(manifold(), x, Eigen::VectorXd::Zero(manifold().TangentSize())), x);
}

TEST_P(PoseManifoldAxioms, PlusKeepsTheQuaternionUnitAndHeldCoordinatesBitByBit) {
  auto rng = test::make_rng("plus");
  const auto& [update, held] = GetParam();
  for (int i = 0; i < 20; ++i) {
    const Vector7 x = random_pose(rng);
    const Vector7 y = plus(manifold(), x, random_tangent(rng, manifold().TangentSize()));
    EXPECT_NEAR(y.head<4>().norm(), 1.0, 1e-15);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(y[4 + k] == x[4 + k], held[k]);
    }
    EXPECT_EQ(y.head<4>() == x.head<4>(), held[3]);
  }
}

TEST_P(PoseManifoldAxioms, PlusJacobianIsTheDerivativeOfPlus) {
  auto rng = test::make_rng("plus jacobian");
  const PoseManifold m = manifold();
  for (int i = 0; i < 20; ++i) {
    const Vector7 x = random_pose(rng);
    const auto f = [&](const Eigen::VectorXd& delta) { return plus(m, x, delta); };
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(m.TangentSize());
    EXPECT_TRUE(is_near(plus_jacobian(m, x), test::numeric_jacobian(f, zero, 1e-2), 1e-9));
  }
}

TEST_P(PoseManifoldAxioms, MinusJacobianIsALeftInverseOfPlusJacobian) {
  auto rng = test::make_rng("minus jacobian");
  const PoseManifold m = manifold();
  const Vector7 x = random_pose(rng);
  const int n = m.TangentSize();
  EXPECT_TRUE(
      is_near(minus_jacobian(m, x) * plus_jacobian(m, x), Eigen::MatrixXd::Identity(n, n), 1e-14));
}

INSTANTIATE_TEST_SUITE_P(
    All,
    PoseManifoldAxioms,
    testing::Combine(testing::Values(TranslationUpdate::COUPLED, TranslationUpdate::ADDITIVE),
                     testing::Values(std::array<bool, 4>{false, false, false, false},
                                     std::array<bool, 4>{false, true, false, false},
                                     std::array<bool, 4>{true, false, true, false},
                                     std::array<bool, 4>{false, false, false, true},
                                     std::array<bool, 4>{true, true, true, false})));

TEST(PoseManifold, CoupledPlusIsTheLeftExponential) {
  auto rng = test::make_rng("left exponential");
  const PoseManifold m(TranslationUpdate::COUPLED);
  for (int i = 0; i < 50; ++i) {
    const Vector7 x = random_pose(rng);
    const Vector6 xi = rng.normal_vector<6>(i % 2 == 0 ? 0.5 : 1e-8);
    EXPECT_TRUE(is_near(to_matrix(plus(m, x, xi)), se3_exp(xi) * to_matrix(x), 1e-14));
  }
}

TEST(PoseManifold, MinusUndoesPlus) {
  auto rng = test::make_rng("minus plus");
  for (const auto update : {TranslationUpdate::COUPLED, TranslationUpdate::ADDITIVE}) {
    const PoseManifold m(update);
    for (int i = 0; i < 50; ++i) {
      const Vector7 x = random_pose(rng);
      const Eigen::VectorXd delta = random_tangent(rng, 6);
      EXPECT_TRUE(is_near(minus(m, plus(m, x, delta), x), delta, 1e-13));
    }
  }
}

}  // namespace
}  // namespace raylign::ceres_backend
