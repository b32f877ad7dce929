// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace raylign {

/// φ(M) = Σ_n Mⁿ / (n + 1)! = ∫₀¹ exp(sM) ds, the matrix function behind V(ω, σ) of Sim(3) and
/// behind every group's left Jacobian, J_l(ξ) = φ(ad_ξ). Scaling and doubling, φ(2M) = φ(M) (exp(M)
/// + I) / 2: no case distinction near zero, relative accuracy about 1e-15. Higham, Functions of
/// Matrices, §10.7.4.
template <int N>
Eigen::Matrix<double, N, N> matrix_phi(const Eigen::Matrix<double, N, N>& M) {
  using Matrix = Eigen::Matrix<double, N, N>;
  constexpr int kNumTerms = 14;      // 0.5¹⁵ / 15! < 1e-16
  constexpr int kMaxDoublings = 64;  // stops for input that is not finite
  const double norm = M.template lpNorm<Eigen::Infinity>() * N;
  int doublings = 0;
  while (std::ldexp(norm, -doublings) > 0.5 && doublings < kMaxDoublings) ++doublings;
  const Matrix scaled = std::ldexp(1.0, -doublings) * M;
  const Matrix identity = Matrix::Identity();
  Matrix phi = identity;
  for (int n = kNumTerms; n >= 1; --n) phi = identity + scaled * phi / (n + 1.0);
  Matrix exponential = identity + scaled * phi;
  for (int i = 0; i < doublings; ++i) {
    phi = 0.5 * phi * (exponential + identity);
    exponential = (exponential * exponential).eval();
  }
  return phi;
}

}  // namespace raylign
