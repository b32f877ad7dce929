// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <type_traits>

namespace raylign::test {

/// Jacobian of f at x by central differences and Ridders' extrapolation (Ridders 1982; Numerical
/// Recipes §5.7): steps h, h/1.4, h/1.4², … are extrapolated to step 0, and each entry keeps the
/// estimate with the smallest error bound. About 1e-11 relative for smooth f when h is a fair part
/// of the scale of x.
template <typename F, int N>
auto numeric_jacobian(const F& f, const Eigen::Matrix<double, N, 1>& x, double h = 1e-2) {
  constexpr int kSize = 10;
  constexpr double kShrink = 1.4;
  using Value = std::decay_t<decltype(f(x).eval())>;
  constexpr int kRows = Value::RowsAtCompileTime;
  const Eigen::Index rows = f(x).rows();
  Eigen::Matrix<double, kRows, N> jacobian(rows, x.rows());
  for (Eigen::Index column = 0; column < x.rows(); ++column) {
    const auto difference = [&](double step) -> Eigen::ArrayXd {
      Eigen::Matrix<double, N, 1> forward = x;
      Eigen::Matrix<double, N, 1> backward = x;
      forward[column] += step;
      backward[column] -= step;
      return ((f(forward) - f(backward)) / (forward[column] - backward[column])).array();
    };
    std::array<std::array<Eigen::ArrayXd, kSize>, kSize> table;
    Eigen::ArrayXd best = Eigen::ArrayXd::Zero(rows);
    Eigen::ArrayXd best_error = Eigen::ArrayXd::Constant(rows, std::numeric_limits<double>::max());
    double step = h;
    for (int i = 0; i < kSize; ++i, step /= kShrink) {
      table[0][i] = difference(step);
      double factor = kShrink * kShrink;
      for (int j = 1; j <= i; ++j, factor *= kShrink * kShrink) {
        table[j][i] = (factor * table[j - 1][i] - table[j - 1][i - 1]) / (factor - 1.0);
        const Eigen::ArrayXd error =
            (table[j][i] - table[j - 1][i]).abs().max((table[j][i] - table[j - 1][i - 1]).abs());
        best = (error <= best_error).select(table[j][i], best);
        best_error = best_error.min(error);
      }
    }
    jacobian.col(column) = best.matrix();
  }
  return jacobian;
}

}  // namespace raylign::test
