// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace raylign {

/// Stumpff functions c_k(x) = Σ_i (−x)^i / (2i + k)! at x = θ²: every coefficient of the
/// exponential and the Jacobians of SO(3) and SE(3) is one of them. Relative accuracy about 1e-15
/// for all θ >= 0.
struct Stumpff {
  double c1;  ///< sin θ / θ
  double c2;  ///< (1 − cos θ) / θ²
  double c3;  ///< (θ − sin θ) / θ³
  double c4;  ///< (θ²/2 − 1 + cos θ) / θ⁴
  double c5;  ///< (θ³/6 − θ + sin θ) / θ⁵
};

/// Stumpff & Weiss 1967; Danby, Fundamentals of Celestial Mechanics, §6.9.
Stumpff stumpff(double theta_squared);

}  // namespace raylign
