// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/camera/bal.h"

namespace raylign {

/// Reprojection residual of a camera, predicted − observed, and its two inner Jacobians. The only
/// definition of this residual: Ceres functors call it, native kernels are tested against it.
///
/// @param p_c         point in the camera frame; any positive multiple of it gives the same pixel
///                    (with BalCamera any negative one too), so homogeneous points pass R x̄ + w t
/// @param intrinsics  parameters of the camera, m of them
/// @param J_p         ∂r/∂p_c, 2×3, optional
/// @param J_intrinsics ∂r/∂intrinsics, 2×m, optional
/// @return false when the camera cannot project the point (Camera::project) or the result is not
/// finite
template <typename Camera = BalCamera>
bool reprojection_residual(const Vector3& p_c,
                           const typename Camera::Params& intrinsics,
                           const Vector2& observed,
                           Vector2& residual,
                           RowMajor<2, 3>* J_p = nullptr,
                           RowMajor<2, Camera::kNumParams>* J_intrinsics = nullptr) {
  const Camera camera(intrinsics);
  if (!camera.project(p_c, residual, J_p, J_intrinsics)) return false;
  residual -= observed;
  return true;
}

/// ∂r/∂ξ, 2×6, for the left perturbation T_cw ← exp(ξ) T_cw, ξ = [υ; ω], of p_c = R_cw x̄ + w t_cw:
/// ∂p_c/∂ξ = [w I | −[p_c]×]. The 2×6 Jacobian of the exercise (there e = observed − predicted:
/// minus this).
inline RowMajor<2, 6> pose_jacobian(const RowMajor<2, 3>& J_p, const Vector3& p_c, double w = 1.0) {
  RowMajor<2, 6> J;
  J.leftCols<3>() = w * J_p;
  for (int row = 0; row < 2; ++row) {
    // −jᵀ[p]× = (p × j)ᵀ, row by row
    J.row(row).tail<3>() = p_c.cross(J_p.row(row).transpose());
  }
  return J;
}

/// ∂r/∂X, 2×3, of p_c = R_cw X + t_cw.
inline RowMajor<2, 3> point_jacobian(const RowMajor<2, 3>& J_p, const Matrix3& R_cw) {
  return J_p * R_cw;
}

}  // namespace raylign
