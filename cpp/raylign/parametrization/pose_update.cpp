// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/parametrization/pose_update.h"

#include "raylign/geometry/so3.h"

namespace raylign {

PoseEmbedding pose_embedding(TranslationUpdate update, const PoseMask& mask, const Vector3& t) {
  int num_free = 0;
  for (int i = 0; i < 6; ++i) num_free += mask.is_free(i) ? 1 : 0;
  PoseEmbedding E = PoseEmbedding::Zero(6, num_free);
  for (int i = 0, column = 0; i < 6; ++i) {
    if (!mask.is_free(i)) continue;
    E(i, column) = 1.0;
    if (i >= 3 && update == TranslationUpdate::COUPLED) {
      const Vector3 moved = Vector3::Unit(i - 3).cross(t);  // d t of this rotation
      for (int k = 0; k < 3; ++k) {
        if (mask.translation[k]) E(k, column) = -moved[k];
      }
    }
    ++column;
  }
  return E;
}

void pose_plus(
    TranslationUpdate update, const PoseMask& mask, const Vector6& xi, Quaternion& q, Vector3& t) {
  const Vector3 phi = xi.tail<3>();
  const Vector3 t_before = t;
  if (phi.isZero(0.0)) {  // a pure translation leaves the quaternion's bits alone
    t += xi.head<3>();
  } else {
    const Quaternion step = quaternion_exp(phi);
    q = (step * q).normalized();
    if (update == TranslationUpdate::COUPLED) {
      t = step * t_before + so3_left_jacobian(phi) * xi.head<3>();
    } else {
      t += xi.head<3>();
    }
  }
  for (int k = 0; k < 3; ++k) {
    if (mask.translation[k]) t[k] = t_before[k];
  }
}

}  // namespace raylign
