// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

/// Sim(3) as 4x4 matrices [sR t; 0 1], s > 0; tangent ξ = [υ; ω; σ], s = exp(σ). Update: S ← exp(ξ)
/// S. Sources: Strasdat, PhD thesis 2012, §2.4.2; Eade, Lie Groups for 2D and 3D Transformations,
/// §6.
namespace raylign {

/// [σI + [ω]× υ; 0 0].
Matrix4 sim3_hat(const Vector7& xi);
/// Inverse of sim3_hat.
Vector7 sim3_vee(const Matrix4& xi_hat);

/// [exp(σ) exp(ω) V υ; 0 1], V = ∫₀¹ exp(s (σI + [ω]×)) ds.
Matrix4 sim3_exp(const Vector7& xi);
/// ξ with ‖ω‖ <= π; at π as so3_log. NaN when the upper left block has no positive determinant.
Vector7 sim3_log(const Matrix4& S);
/// [Rᵀ/s −Rᵀt/s; 0 1].
Matrix4 sim3_inverse(const Matrix4& S);
/// Ad_S with S exp(ξ) S⁻¹ = exp(Ad_S ξ): [sR [t]×R −t; 0 R 0; 0 0 1].
Matrix7 sim3_adjoint(const Matrix4& S);

/// J_l with exp(ξ + δ) ≈ exp(J_l(ξ) δ) exp(ξ): φ(ad_ξ) by matrix_phi, relative accuracy 1e-14.
Matrix7 sim3_left_jacobian(const Vector7& xi);
/// J_r with exp(ξ + δ) ≈ exp(ξ) exp(J_r(ξ) δ); J_r(ξ) = J_l(−ξ).
Matrix7 sim3_right_jacobian(const Vector7& xi);
/// J_l⁻¹ for ‖ω‖ < 2π.
Matrix7 sim3_left_jacobian_inverse(const Vector7& xi);
/// J_r⁻¹ for ‖ω‖ < 2π.
Matrix7 sim3_right_jacobian_inverse(const Vector7& xi);

}  // namespace raylign
