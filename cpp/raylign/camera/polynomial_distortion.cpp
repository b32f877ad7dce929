// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/polynomial_distortion.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raylign {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxNewtonSteps = 50;
constexpr int kMaxHalvings = 40;
// A root is accepted when the residual is at the level of rounding, relative to 1 + ‖p_distorted‖.
constexpr double kTolerance = 1e-13;

// d(r d(r²))/dr = 1 + 3 k1 x + 5 k2 x² + 7 k3 x³ at x = r².
struct RadialSlope {
  double c1, c2, c3;

  double operator()(double x) const { return 1.0 + x * (c1 + x * (c2 + x * c3)); }

  // Positive zeros of the derivative c1 + 2 c2 x + 3 c3 x², ascending; infinity where there is
  // none.
  std::array<double, 2> critical_points() const {
    std::array<double, 2> roots = {kInfinity, kInfinity};
    const double discriminant = c2 * c2 - 3.0 * c1 * c3;
    if (discriminant < 0.0) return roots;
    const double q = -(c2 + std::copysign(std::sqrt(discriminant), c2));
    if (c3 != 0.0) roots[0] = q / (3.0 * c3);
    if (q != 0.0) roots[1] = c1 / q;
    for (double& root : roots) root = root > 0.0 ? root : kInfinity;
    std::sort(roots.begin(), roots.end());
    return roots;
  }

  bool falls_at_infinity() const {
    if (c3 != 0.0) return c3 < 0.0;
    return c2 != 0.0 ? c2 < 0.0 : c1 < 0.0;
  }
};

double bisect(const RadialSlope& slope, double positive, double negative) {
  for (;;) {
    const double middle = 0.5 * (positive + negative);
    if (middle <= positive || middle >= negative) return positive;
    (slope(middle) > 0.0 ? positive : negative) = middle;
  }
}

}  // namespace

Vector2 PolynomialDistortion::distort(const Vector2& p,
                                      RowMajor<2, 2>* J_p,
                                      ParamJacobian* J_params) const {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (J_p != nullptr) {
    const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // 2 d(radial)/d(r²)
    const double mixed = slope * x * y + 2.0 * (p1 * x + p2 * y);
    *J_p << radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed,  //
        mixed, radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  if (J_params != nullptr) {
    const double r4 = r2 * r2;
    *J_params << x * r2, x * r4, 2.0 * x * y, r2 + 2.0 * x * x, x * r4 * r2,  //
        y * r2, y * r4, r2 + 2.0 * y * y, 2.0 * x * y, y * r4 * r2;
  }
  return {radial * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          radial * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

bool PolynomialDistortion::undistort(const Vector2& p_distorted,
                                     double max_radius_squared,
                                     Vector2& p,
                                     RowMajor<2, 2>& J_p) const {
  if (!p_distorted.allFinite()) return false;
  const double tolerance = kTolerance * (1.0 + p_distorted.norm());
  p = p_distorted;
  if (p.squaredNorm() >= max_radius_squared) p *= 0.5 * std::sqrt(max_radius_squared) / p.norm();
  Vector2 residual = distort(p, &J_p) - p_distorted;
  // The Jacobian at p = 0 is the identity; with parameters that are not finite none is ever
  // positive.
  for (int halvings = 0; !(J_p.determinant() > 0.0); ++halvings) {
    if (halvings == kMaxHalvings) return false;
    p *= 0.5;
    residual = distort(p, &J_p) - p_distorted;
  }
  for (int step = 0; step < kMaxNewtonSteps && residual.norm() > 0.0; ++step) {
    const Vector2 newton = J_p.inverse() * residual;
    double length = 1.0;
    Vector2 trial;
    Vector2 trial_residual;
    RowMajor<2, 2> trial_J;
    // Halve until the step stays on the one-to-one branch and brings the residual down.
    const auto is_better = [&] {
      trial = p - length * newton;
      if (!(trial.squaredNorm() < max_radius_squared)) return false;
      trial_residual = distort(trial, &trial_J) - p_distorted;
      return trial_J.determinant() > 0.0 && trial_residual.norm() < residual.norm();
    };
    int halvings = 0;
    while (!is_better() && ++halvings < kMaxHalvings) length *= 0.5;
    if (halvings == kMaxHalvings) break;  // at rounding level, or stuck at the fold
    p = trial;
    residual = trial_residual;
    J_p = trial_J;
  }
  return residual.norm() <= tolerance;
}

double PolynomialDistortion::max_radius_squared() const {
  const RadialSlope slope{3.0 * k1, 5.0 * k2, 7.0 * k3};
  double lower = 0.0;
  for (const double upper : slope.critical_points()) {
    if (!std::isfinite(upper)) break;
    if (slope(upper) <= 0.0) return bisect(slope, lower, upper);
    lower = upper;
  }
  if (!slope.falls_at_infinity()) return kInfinity;
  double upper = std::max(1.0, 2.0 * lower);
  while (slope(upper) > 0.0 && upper < 1e100) upper *= 2.0;
  return bisect(slope, lower, upper);
}

}  // namespace raylign
