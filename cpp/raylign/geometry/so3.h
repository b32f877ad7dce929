// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

/// SO(3) as 3x3 matrices; tangent ω = rotation vector in rad. Update from the left: R ← exp(ω) R.
/// Sources: Barfoot, State Estimation for Robotics, ch. 7; Solà et al. 2018.
namespace raylign {

/// [ω]×: the matrix with [ω]× v = ω × v.
Matrix3 so3_hat(const Vector3& omega);
/// Inverse of so3_hat; reads the antisymmetric part, (M − Mᵀ) / 2.
Vector3 so3_vee(const Matrix3& omega_hat);

/// Rodrigues' formula; full accuracy for every ‖ω‖, zero included.
Matrix3 so3_exp(const Vector3& omega);
/// The same with J_left = so3_left_jacobian(ω) from the same sine and cosine: for inner loops.
Matrix3 so3_exp_and_left_jacobian(const Vector3& omega, Matrix3& J_left);
/// ω with ‖ω‖ <= π. At ‖ω‖ = π, where ω and −ω are the same rotation, either may come back.
/// A matrix that is off SO(3) by ε gives a rotation vector off by O(ε).
Vector3 so3_log(const Matrix3& R);

/// J_l with exp(ω + δ) ≈ exp(J_l(ω) δ) exp(ω). Barfoot eq. (7.77).
Matrix3 so3_left_jacobian(const Vector3& omega);
/// J_r with exp(ω + δ) ≈ exp(ω) exp(J_r(ω) δ); J_r(ω) = J_l(−ω).
Matrix3 so3_right_jacobian(const Vector3& omega);
/// J_l⁻¹ for ‖ω‖ < 2π, where J_l becomes singular.
Matrix3 so3_left_jacobian_inverse(const Vector3& omega);
/// J_r⁻¹ for ‖ω‖ < 2π.
Matrix3 so3_right_jacobian_inverse(const Vector3& omega);

/// Ad_R with R exp(ω) R⁻¹ = exp(Ad_R ω): R itself. There so that the three groups read alike.
Matrix3 so3_adjoint(const Matrix3& R);

}  // namespace raylign
