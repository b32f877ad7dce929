// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/eigen.h"

namespace raylign {

/// A Bundle-Adjustment-in-the-Large problem (Agarwal et al., ECCV 2010) as plain arrays.
///
/// Camera row: [ω (3, angle-axis of R_cw), t (3, t_cw), f, k1, k2]; the camera looks along −z:
///   P = R_cw X + t,  p = −P_xy / P_z,  (u, v) = f (1 + k1 ‖p‖² + k2 ‖p‖⁴) p,  v up.
/// Numbers and axes are the file's own; nothing is flipped, scaled or reordered here.
struct BalProblem {
  Rows<double, 9> cameras;             ///< (C, 9)
  Rows<double, 3> points;              ///< (P, 3) world frame, scene units
  Rows<std::int32_t, 1> camera_index;  ///< (N,) in [0, C)
  Rows<std::int32_t, 1> point_index;   ///< (N,) in [0, P)
  Rows<double, 2> observations;        ///< (N, 2) pixels, principal point at the origin
  Rows<std::uint8_t, 3> colors;        ///< (P, 3) RGB, or (0, 3) when unknown

  std::int64_t num_cameras() const { return cameras.rows(); }
  std::int64_t num_points() const { return points.rows(); }
  std::int64_t num_observations() const { return observations.rows(); }

  /// Throws ShapeError when lengths disagree, a table has more than 2³¹ − 1 rows or an index is out
  /// of range. Values are not looked at: NaN is the business of whoever computes with it.
  void validate() const;
};

/// Bitwise equality of every array: 0.0 and -0.0 differ, a NaN equals the same NaN.
bool operator==(const BalProblem& a, const BalProblem& b);
bool operator!=(const BalProblem& a, const BalProblem& b);

}  // namespace raylign
