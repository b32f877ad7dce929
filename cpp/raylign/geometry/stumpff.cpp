// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/stumpff.h"

#include <cmath>

namespace raylign {
namespace {

// Below it the series, above it the closed forms: at θ = 2 the worst of them, c5, loses two bits.
constexpr double kSeriesLimit = 4.0;

// Σ_i (−x)^i / (2i + k)!, Horner form. 14 terms leave less than 1e-20 at x = 4.
double series(double x, int k) {
  double sum = 1.0;
  for (int n = k + 28; n > k; n -= 2) sum = 1.0 - sum * x / (n * (n - 1.0));
  return sum;
}

}  // namespace

Stumpff stumpff(double theta_squared) {
  const double x = theta_squared;
  Stumpff c;
  if (x < kSeriesLimit) {
    c.c4 = series(x, 4) / 24.0;
    c.c5 = series(x, 5) / 120.0;
    // c_k = 1/k! − x c_{k+2}: downwards, so that errors shrink.
    c.c3 = 1.0 / 6.0 - x * c.c5;
    c.c2 = 1.0 / 2.0 - x * c.c4;
    c.c1 = 1.0 - x * c.c3;
    return c;
  }
  const double theta = std::sqrt(x);
  const double half_sine = std::sin(theta / 2.0);
  c.c1 = std::sin(theta) / theta;
  c.c2 = 2.0 * half_sine * half_sine / x;  // not 1 − cos θ, which cancels near 2π
  c.c3 = (1.0 - c.c1) / x;
  c.c4 = (0.5 - c.c2) / x;
  c.c5 = (1.0 / 6.0 - c.c3) / x;
  return c;
}

}  // namespace raylign
