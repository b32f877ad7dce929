// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/portable_math.h"

#include <cmath>

namespace raylign::portable {
namespace {

// Splits of ln 2 and π/2 whose leading parts have trailing zero bits: k · part is exact for small
// k. Cody & Waite 1980, ch. 6 and 8; the constants are those of every libm.
constexpr double kLn2High = 6.93147180369123816490e-01;
constexpr double kLn2Low = 1.90821492927058770002e-10;
constexpr double kHalfPi1 = 1.57079632673412561417e+00;
constexpr double kHalfPi2 = 6.07710050630396597660e-11;
constexpr double kHalfPi3 = 2.02226624879595063154e-21;
constexpr double kPi = 3.14159265358979323846;

// Σ_{i=0}^{n−1} (sign)^i x^i / (2i + 1): the common series of atan (sign = −1) and atanh (sign =
// +1).
double odd_reciprocal_series(double x, double sign, int n) {
  double sum = 0.0;
  for (int i = n - 1; i >= 0; --i) sum = sum * (sign * x) + 1.0 / (2 * i + 1);
  return sum;
}

// atan on [0, 1]: two half-angle steps, atan x = 2 atan(x / (1 + √(1 + x²))), then the series at <=
// 0.199.
double atan_unit(double x) {
  x /= 1.0 + std::sqrt(1.0 + x * x);
  x /= 1.0 + std::sqrt(1.0 + x * x);
  return 4.0 * x * odd_reciprocal_series(x * x, -1.0, 12);
}

// Taylor polynomials on |x| <= π/4 by Horner; the first omitted terms are below 1e-19.
double sin_kernel(double x) {
  const double x2 = x * x;
  double sum = 1.0;
  for (int i = 8; i >= 1; --i) sum = 1.0 - sum * x2 / ((2 * i) * (2 * i + 1));
  return x * sum;
}

double cos_kernel(double x) {
  const double x2 = x * x;
  double sum = 1.0;
  for (int i = 9; i >= 1; --i) sum = 1.0 - sum * x2 / ((2 * i - 1) * (2 * i));
  return sum;
}

}  // namespace

double log(double x) {
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // exact, in [0.5, 1)
  if (mantissa < 0.70710678118654752) {
    mantissa *= 2.0;
    --exponent;
  }
  // log m = 2 atanh((m − 1) / (m + 1)), |argument| <= 0.1716.
  const double s = (mantissa - 1.0) / (mantissa + 1.0);
  return exponent * kLn2High +
         (2.0 * s * odd_reciprocal_series(s * s, 1.0, 11) + exponent * kLn2Low);
}

double exp(double x) {
  const double k = std::floor(x / (kLn2High + kLn2Low) + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;
  double sum = 1.0;
  for (int i = 13; i >= 1; --i) sum = 1.0 + sum * r / i;
  return std::ldexp(sum, static_cast<int>(k));
}

SinCos sincos(double x) {
  const double k = std::floor(x / (kHalfPi1 + kHalfPi2) + 0.5);
  const double r = ((x - k * kHalfPi1) - k * kHalfPi2) - k * kHalfPi3;
  const double s = sin_kernel(r);
  const double c = cos_kernel(r);
  switch (static_cast<long long>(k) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double atan2(double y, double x) {
  const double abs_x = std::abs(x);
  const double abs_y = std::abs(y);
  if (abs_x == 0.0 && abs_y == 0.0) return 0.0;
  double angle = abs_y <= abs_x ? atan_unit(abs_y / abs_x) : 0.5 * kPi - atan_unit(abs_x / abs_y);
  if (x < 0.0) angle = kPi - angle;
  return y < 0.0 ? -angle : angle;
}

}  // namespace raylign::portable
