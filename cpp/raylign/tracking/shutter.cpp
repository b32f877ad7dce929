// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/shutter.h"

#include "raylign/geometry/se3.h"

namespace raylign {

Vector6 Shutter::target_velocity(const Matrix4& T_th) const {
  if (!(elapsed_s > 0.0)) return Vector6::Zero();
  return se3_log(T_th * se3_inverse(T_before_h)) / elapsed_s;
}

}  // namespace raylign
