// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Elementary functions whose bits do not depend on the C library, the processor or the compiler:
/// they use only + − × ÷ and sqrt, which IEEE 754 fixes. glibc picks FMA variants at run time, so
/// that even one binary gives other last bits on another machine; synthetic data made from a seed
/// must not. Accuracy: within 4 ulp of the exact value on the ranges given. Built with
/// -ffp-contract=off.
namespace raylign::portable {

/// Natural logarithm of a finite, normal x > 0.
double log(double x);

/// eˣ for |x| <= 700.
double exp(double x);

struct SinCos {
  double sin;
  double cos;
};

/// Sine and cosine of x in radians, |x| <= 1e5.
SinCos sincos(double x);

/// Angle of (x, y) in (−π, π]; 0 for the origin.
double atan2(double y, double x);

}  // namespace raylign::portable
