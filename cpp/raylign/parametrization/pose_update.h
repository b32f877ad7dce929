// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "raylign/base/eigen.h"
#include "raylign/geometry/quaternion.h"

namespace raylign {

/// How a rotation step φ and a translation step υ act on a pose (q, t) with tangent [υ; φ]; the
/// rotation moves as R ← Exp(φ) R in both.
enum class TranslationUpdate {
  COUPLED,   ///< SE(3): T ← exp(ξ) T, so t ← Exp(φ) t + J_l(φ) υ
  ADDITIVE,  ///< t ← t + υ
};

/// What of a pose is held constant; it is held exactly, not to first order.
struct PoseMask {
  std::array<bool, 3> translation{false, false, false};
  bool rotation = false;

  bool any() const { return rotation || translation[0] || translation[1] || translation[2]; }
  bool all() const { return rotation && translation[0] && translation[1] && translation[2]; }
  /// Tangent index 0..2: a translation coordinate, 3..5: the rotation.
  bool is_free(int tangent_index) const {
    return tangent_index < 3 ? !translation[tangent_index] : !rotation;
  }
};

using PoseEmbedding = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

/// Full tangent ξ = [υ; φ] = E δ of the free coordinates δ at translation t. Held coordinates leave
/// the tangent space: with COUPLED a held t_k asks υ_k = −(φ × t)_k.
PoseEmbedding pose_embedding(TranslationUpdate update, const PoseMask& mask, const Vector3& t);

/// (q, t) moved by ξ; held coordinates of t and, for φ = 0, q keep their bits.
void pose_plus(
    TranslationUpdate update, const PoseMask& mask, const Vector6& xi, Quaternion& q, Vector3& t);

}  // namespace raylign
