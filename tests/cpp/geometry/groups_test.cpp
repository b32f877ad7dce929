// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// The axioms of the three groups, written once and run for each.
#include <gtest/gtest.h>

#include "geometry/groups.h"
#include "support/eigen_matchers.h"
#include "support/numeric_jacobian.h"

namespace raylign::test {
namespace {

template <typename Group>
class GroupTest : public testing::Test {};
using Groups = testing::Types<So3, Se3, Sim3>;
TYPED_TEST_SUITE(GroupTest, Groups);

TYPED_TEST(GroupTest, IdentityIsExact) {
  using G = TypeParam;
  const typename G::Element identity = G::Element::Identity();
  EXPECT_EQ(G::exp(G::Tangent::Zero()), identity);
  EXPECT_EQ(G::log(identity), G::Tangent::Zero());
  EXPECT_EQ(G::inverse(identity), identity);
  EXPECT_EQ(G::adjoint(identity), G::Jacobian::Identity());
  EXPECT_EQ(G::left_jacobian(G::Tangent::Zero()), G::Jacobian::Identity());
}

TYPED_TEST(GroupTest, InverseAndAssociativity) {
  using G = TypeParam;
  for (int i = 0; i < 20; ++i) {
    NamedRng rng = make_rng("group_inverse", i);
    const auto a = G::exp(random_tangent<G>(rng, 2.0));
    const auto b = G::exp(random_tangent<G>(rng, 1.0));
    const auto c = G::exp(random_tangent<G>(rng, 3.0));
    EXPECT_TRUE(is_near(a * G::inverse(a), G::Element::Identity(), 1e-14));
    EXPECT_TRUE(is_near(G::inverse(a) * a, G::Element::Identity(), 1e-14));
    EXPECT_TRUE(is_near((a * b) * c, a * (b * c), 1e-14));
    EXPECT_TRUE(is_near(G::inverse(a * b), G::inverse(b) * G::inverse(a), 1e-13));
  }
}

TYPED_TEST(GroupTest, VeeInvertsHat) {
  using G = TypeParam;
  NamedRng rng = make_rng("group_hat");
  const auto xi = random_tangent<G>(rng, 1.3);
  EXPECT_TRUE(is_near(G::vee(G::hat(xi)), xi, 1e-15));
}

TYPED_TEST(GroupTest, ExpIsTheMatrixExponential) {
  using G = TypeParam;
  for (const double angle : test_angles()) {
    NamedRng rng = make_rng("group_exp", static_cast<int>(1e3 * angle));
    const auto xi = random_tangent<G>(rng, angle);
    EXPECT_TRUE(is_near(G::exp(xi), long_double_series(G::hat(xi), 0), 2e-15)) << angle;
    EXPECT_TRUE(is_near(G::exp(-xi) * G::exp(xi), G::Element::Identity(), 1e-14)) << angle;
  }
}

TYPED_TEST(GroupTest, LogInvertsExp) {
  using G = TypeParam;
  for (const double angle : test_angles()) {
    NamedRng rng = make_rng("group_log", static_cast<int>(1e3 * angle));
    const auto xi = random_tangent<G>(rng, angle);
    EXPECT_TRUE(is_near(G::log(G::exp(xi)), xi, 2e-14)) << angle;
  }
}

TYPED_TEST(GroupTest, AdjointMovesTangentsAcross) {
  using G = TypeParam;
  for (int i = 0; i < 20; ++i) {
    NamedRng rng = make_rng("group_adjoint", i);
    const auto T = G::exp(random_tangent<G>(rng, 2.0));
    const auto U = G::exp(random_tangent<G>(rng, 1.5));
    const auto xi = random_tangent<G>(rng, 0.7);
    const typename G::Tangent moved = G::adjoint(T) * xi;
    EXPECT_TRUE(is_near(T * G::exp(xi) * G::inverse(T), G::exp(moved), 1e-13));
    EXPECT_TRUE(is_near(G::adjoint(T * U), G::adjoint(T) * G::adjoint(U), 1e-13));
    EXPECT_TRUE(
        is_near(G::adjoint(G::exp(xi)), long_double_series(commutator_ad<G>(xi), 0), 1e-13));
  }
}

TYPED_TEST(GroupTest, JacobiansAgainstTheSeriesOfAd) {
  using G = TypeParam;
  for (const double angle : test_angles()) {
    NamedRng rng = make_rng("group_jacobian_series", static_cast<int>(1e3 * angle));
    const auto xi = random_tangent<G>(rng, angle);
    const auto ad = commutator_ad<G>(xi);
    EXPECT_TRUE(is_near(G::left_jacobian(xi), long_double_series(ad, 1), 1e-14)) << angle;
    EXPECT_TRUE(is_near(G::right_jacobian(xi), long_double_series(-ad, 1), 1e-14)) << angle;
  }
}

TYPED_TEST(GroupTest, JacobiansAgainstNumericDerivatives) {
  using G = TypeParam;
  using Tangent = typename G::Tangent;
  for (const double angle : {0.0, 1e-9, 1e-3, 0.5, 1.99, 2.01, 3.1}) {
    NamedRng rng = make_rng("group_jacobian_numeric", static_cast<int>(1e3 * angle));
    const Tangent xi = random_tangent<G>(rng, angle);
    const auto inverse = G::inverse(G::exp(xi));
    const auto left = [&](const Tangent& x) -> Tangent { return G::log(G::exp(x) * inverse); };
    const auto right = [&](const Tangent& x) -> Tangent { return G::log(inverse * G::exp(x)); };
    EXPECT_TRUE(is_near(G::left_jacobian(xi), numeric_jacobian(left, xi), 1e-10)) << angle;
    EXPECT_TRUE(is_near(G::right_jacobian(xi), numeric_jacobian(right, xi), 1e-10)) << angle;
  }
}

TYPED_TEST(GroupTest, InverseJacobiansInvert) {
  using G = TypeParam;
  std::vector<double> angles = test_angles();
  for (const double angle : {3.5, 4.5, 5.5, 6.0}) angles.push_back(angle);
  for (const double angle : angles) {
    NamedRng rng = make_rng("group_jacobian_inverse", static_cast<int>(1e3 * angle));
    const auto xi = random_tangent<G>(rng, angle);
    const auto identity = G::Jacobian::Identity();
    EXPECT_TRUE(is_near(G::left_jacobian_inverse(xi) * G::left_jacobian(xi), identity, 1e-12));
    EXPECT_TRUE(is_near(G::right_jacobian_inverse(xi) * G::right_jacobian(xi), identity, 1e-12));
  }
}

TYPED_TEST(GroupTest, AdjointTurnsRightJacobianIntoLeft) {
  using G = TypeParam;
  NamedRng rng = make_rng("group_left_right");
  const auto xi = random_tangent<G>(rng, 2.2);
  EXPECT_TRUE(is_near(G::adjoint(G::exp(xi)) * G::right_jacobian(xi), G::left_jacobian(xi), 1e-13));
}

}  // namespace
}  // namespace raylign::test
