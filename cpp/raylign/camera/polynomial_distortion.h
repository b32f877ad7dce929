// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

namespace raylign {

/// Radial and tangential distortion of normalised image coordinates p = (x, y). Brown 1971; OpenCV:
///   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
///   y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y
/// Shared by RadtanCamera and, with p1 = p2 = k3 = 0, BalCamera.
struct PolynomialDistortion {
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double k3 = 0.0;

  /// Jacobian by (k1, k2, p1, p2, k3).
  using ParamJacobian = RowMajor<2, 5>;

  Vector2 distort(const Vector2& p,
                  RowMajor<2, 2>* J_p = nullptr,
                  ParamJacobian* J_params = nullptr) const;

  /// Finds p with distort(p) = p_distorted, where distort is one to one: the branch connected with
  /// p = 0. Damped Newton, to rounding; false when there is no such p. J_p is the Jacobian of
  /// distort at p.
  bool undistort(const Vector2& p_distorted,
                 double max_radius_squared,
                 Vector2& p,
                 RowMajor<2, 2>& J_p) const;

  /// Smallest r² > 0 where r (1 + k1 r² + k2 r⁴ + k3 r⁶) stops growing: beyond it the image folds
  /// back and a pixel has no unique ray. Infinity when it grows for ever.
  double max_radius_squared() const;
};

}  // namespace raylign
