// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "raylign/geometry/se3.h"
#include "raylign/geometry/sim3.h"
#include "raylign/geometry/so3.h"
#include "support/named_rng.h"

/// The three groups behind one static interface, so that the axioms are written once.
namespace raylign::test {

#define RAYLIGN_TEST_GROUP(Group, prefix, TangentType, ElementType)                           \
  struct Group {                                                                              \
    using Tangent = TangentType;                                                              \
    using Element = ElementType;                                                              \
    static constexpr int kDof = Tangent::RowsAtCompileTime;                                   \
    static constexpr int kOmega = kDof == 3 ? 0 : 3; /* where ω starts */                     \
    using Jacobian = Eigen::Matrix<double, kDof, kDof>;                                       \
    static Element hat(const Tangent& xi) { return prefix##_hat(xi); }                        \
    static Tangent vee(const Element& m) { return prefix##_vee(m); }                          \
    static Element exp(const Tangent& xi) { return prefix##_exp(xi); }                        \
    static Tangent log(const Element& T) { return prefix##_log(T); }                          \
    static Jacobian adjoint(const Element& T) { return prefix##_adjoint(T); }                 \
    static Jacobian left_jacobian(const Tangent& xi) { return prefix##_left_jacobian(xi); }   \
    static Jacobian right_jacobian(const Tangent& xi) { return prefix##_right_jacobian(xi); } \
    static Jacobian left_jacobian_inverse(const Tangent& xi) {                                \
      return prefix##_left_jacobian_inverse(xi);                                              \
    }                                                                                         \
    static Jacobian right_jacobian_inverse(const Tangent& xi) {                               \
      return prefix##_right_jacobian_inverse(xi);                                             \
    }                                                                                         \
    static Element inverse(const Element& T);                                                 \
  }

RAYLIGN_TEST_GROUP(So3, so3, Vector3, Matrix3);
RAYLIGN_TEST_GROUP(Se3, se3, Vector6, Matrix4);
RAYLIGN_TEST_GROUP(Sim3, sim3, Vector7, Matrix4);
#undef RAYLIGN_TEST_GROUP

inline Matrix3 So3::inverse(const Matrix3& R) { return R.transpose(); }
inline Matrix4 Se3::inverse(const Matrix4& T) { return se3_inverse(T); }
inline Matrix4 Sim3::inverse(const Matrix4& S) { return sim3_inverse(S); }

/// Random tangent with ‖ω‖ = angle, translation of order 1, |σ| of order 0.5.
template <typename Group>
typename Group::Tangent random_tangent(NamedRng& rng, double angle) {
  typename Group::Tangent xi = rng.normal_vector<Group::kDof>();
  xi.template segment<3>(Group::kOmega) = angle * rng.unit_vector<3>();
  if constexpr (Group::kDof == 7) xi[6] *= 0.5;
  return xi;
}

/// Zero, tiny, small, across the switch of the series (θ = 2), up to one ulp-ish below π.
inline std::vector<double> test_angles() {
  const double pi = std::acos(-1.0);
  return {0.0,        1e-200,     1e-20, 1e-12, 1e-10,     1e-8,      1e-7,     1e-6,
          1e-5,       1e-4,       1e-3,  1e-2,  0.1,       0.5,       1.0,      1.9,
          2.0 - 1e-9, 2.0 + 1e-9, 2.5,   3.0,   pi - 1e-3, pi - 1e-6, pi - 1e-9};
}

template <int N>
using LongMatrix = Eigen::Matrix<long double, N, N>;

/// Σ Mⁿ / (n + shift)! in long double: shift 0 is exp, shift 1 is φ. For ‖M‖ up to about 8.
template <typename Derived>
auto long_double_series(const Eigen::MatrixBase<Derived>& m, int shift) {
  constexpr int kSize = Derived::RowsAtCompileTime;
  const LongMatrix<kSize> M = m.template cast<long double>();
  LongMatrix<kSize> term = LongMatrix<kSize>::Identity();
  LongMatrix<kSize> sum = term;
  for (int n = 1; n < 90; ++n) {
    term = (term * M / static_cast<long double>(n + shift)).eval();
    sum += term;
  }
  return sum.template cast<double>().eval();
}

/// ad_ξ column by column from the commutator of hat matrices: independent of every formula under
/// test.
template <typename Group>
typename Group::Jacobian commutator_ad(const typename Group::Tangent& xi) {
  typename Group::Jacobian ad;
  const typename Group::Element X = Group::hat(xi);
  for (int i = 0; i < Group::kDof; ++i) {
    const typename Group::Element E = Group::hat(Group::Tangent::Unit(i));
    ad.col(i) = Group::vee(X * E - E * X);
  }
  return ad;
}

}  // namespace raylign::test
