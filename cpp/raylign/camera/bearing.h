// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "raylign/base/eigen.h"

namespace raylign {

/// Points nearer than this to the plane of the camera centre, in scene units, have no projection.
constexpr double kMinDepth = 1e-12;

/// Unit vector through (p, z) with z = +1 or −1 (which way the camera looks), and its Jacobian by
/// p.
inline Vector3 bearing_from_normalized(const Vector2& p, double z, RowMajor<3, 2>* J_p = nullptr) {
  const double inverse_norm = 1.0 / std::sqrt(1.0 + p.squaredNorm());
  const Vector3 bearing = inverse_norm * Vector3(p.x(), p.y(), z);
  if (J_p != nullptr) {
    *J_p = -inverse_norm * bearing * bearing.head<2>().transpose();
    J_p->topRows<2>().diagonal().array() += inverse_norm;
  }
  return bearing;
}

}  // namespace raylign
