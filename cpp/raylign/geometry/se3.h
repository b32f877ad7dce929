// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

/// SE(3) as 4x4 matrices [R t; 0 1]; tangent ξ = [υ; ω], translation first. Update: T ← exp(ξ) T.
/// Sources: Barfoot, State Estimation for Robotics, ch. 7; Barfoot & Furgale 2014.
namespace raylign {

/// [[ω]× υ; 0 0].
Matrix4 se3_hat(const Vector6& xi);
/// Inverse of se3_hat.
Vector6 se3_vee(const Matrix4& xi_hat);

/// [exp(ω) J_l(ω) υ; 0 1].
Matrix4 se3_exp(const Vector6& xi);
/// ξ with ‖ω‖ <= π; at π as so3_log.
Vector6 se3_log(const Matrix4& T);
/// [Rᵀ −Rᵀt; 0 1].
Matrix4 se3_inverse(const Matrix4& T);
/// Ad_T with T exp(ξ) T⁻¹ = exp(Ad_T ξ): [R [t]×R; 0 R].
Matrix6 se3_adjoint(const Matrix4& T);

/// J_l with exp(ξ + δ) ≈ exp(J_l(ξ) δ) exp(ξ): [J_l(ω) Q(υ, ω); 0 J_l(ω)]. Barfoot eq. (7.85).
Matrix6 se3_left_jacobian(const Vector6& xi);
/// J_r with exp(ξ + δ) ≈ exp(ξ) exp(J_r(ξ) δ); J_r(ξ) = J_l(−ξ).
Matrix6 se3_right_jacobian(const Vector6& xi);
/// J_l⁻¹ for ‖ω‖ < 2π. Barfoot eq. (7.95).
Matrix6 se3_left_jacobian_inverse(const Vector6& xi);
/// J_r⁻¹ for ‖ω‖ < 2π.
Matrix6 se3_right_jacobian_inverse(const Vector6& xi);

}  // namespace raylign
