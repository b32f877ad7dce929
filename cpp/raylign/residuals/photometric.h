// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if defined(__GNUC__)
#define RAYLIGN_ALWAYS_INLINE __attribute__((always_inline)) inline
#else
#define RAYLIGN_ALWAYS_INLINE inline
#endif

/// The variance-normalised photometric residual of LSD-SLAM (Engel, Schöps, Cremers, ECCV 2014,
/// §3.3, equations 12 to 15) and the inverse-depth residual that goes with it. The only definition:
/// the tracker's kernel, its maps, the Ceres oracle and the tests all call these functions.
///
/// A keyframe pixel p with intensity I_h(p), inverse depth D(p) and its variance V(p) is moved by
/// T_th = [R t] (for Sim(3) R stands for sR) and projected at p' into the target image I_t. Plain
/// arithmetic on scalars, no branches: S is double, or float in loops that the compiler vectorises.
/// docs/theory/tracking.md derives each line.
namespace raylign {

/// T_th and the target's intrinsics.
template <typename S>
struct WarpPose {
  S R[9];  ///< by rows; sR for Sim(3)
  S t[3];
  S fx, fy, cx, cy;  ///< px
};

/// Where a point of the keyframe lands. q = D X' = R K⁻¹(u, v, 1) + D t: D = 0, a point at
/// infinity, is no special case.
template <typename S>
struct WarpedPoint {
  S x, y;       ///< X'/Z', Y'/Z'
  S inverse_q;  ///< 1 / q_z = 1 / (D Z'); > 0 in front of the target camera
  S inverse_z;  ///< 1 / Z'
  S u, v;       ///< p', px
};

/// p' = π(T_th π⁻¹(p, D)), eq. 3.
/// @param ray_x, ray_y  K⁻¹(u, v, 1) of the keyframe's pixel
template <typename S>
RAYLIGN_ALWAYS_INLINE WarpedPoint<S> warp(S ray_x, S ray_y, S D, const WarpPose<S>& T) {
  const S q_x = T.R[0] * ray_x + T.R[1] * ray_y + T.R[2] + T.t[0] * D;
  const S q_y = T.R[3] * ray_x + T.R[4] * ray_y + T.R[5] + T.t[1] * D;
  const S q_z = T.R[6] * ray_x + T.R[7] * ray_y + T.R[8] + T.t[2] * D;
  WarpedPoint<S> p;
  p.inverse_q = S(1) / q_z;
  p.inverse_z = D * p.inverse_q;
  p.x = q_x * p.inverse_q;
  p.y = q_y * p.inverse_q;
  p.u = T.fx * p.x + T.cx;
  p.v = T.fy * p.y + T.cy;
  return p;
}

/// r = I_h(p) − (e^a I_t(p') + b), eq. 13 with brightness on the target's side. The columns of a
/// and b are −gain I_t and −1.
/// @param gain  e^a
template <typename S>
RAYLIGN_ALWAYS_INLINE S photometric_residual(S I_h, S I_t, S gain, S b) {
  return I_h - (gain * I_t + b);
}

/// ∂(u', v')/∂D of the projection, scaled by the focal lengths: the epipolar direction at p'.
/// Exact, with the rotation in it: ∂X'/∂D = −(X' − t) / D.
template <typename S>
struct EpipolarStep {
  S u, v;
};

template <typename S>
RAYLIGN_ALWAYS_INLINE EpipolarStep<S> epipolar_step(const WarpedPoint<S>& p, const WarpPose<S>& T) {
  return {T.fx * (T.t[0] - T.t[2] * p.x) * p.inverse_q,
          T.fy * (T.t[1] - T.t[2] * p.y) * p.inverse_q};
}

/// ∂r/∂D, the derivative of eq. 14.
/// @param g_u, g_v  e^a ∇I_t(p'), grey / px
template <typename S>
RAYLIGN_ALWAYS_INLINE S photometric_d_inverse_depth(const EpipolarStep<S>& step, S g_u, S g_v) {
  return -(g_u * step.u + g_v * step.v);
}

/// Sum of the squared bilinear weights at the sub-pixel phase (f, g): what interpolation leaves of
/// independent pixel noise; 4/9 on average.
template <typename S>
RAYLIGN_ALWAYS_INLINE S bilinear_noise_factor(S f, S g) {
  const S f0 = S(1) - f;
  const S g0 = S(1) - g;
  return (f0 * f0 + f * f) * (g0 * g0 + g * g);
}

/// σ_r² of eq. 14: intensity noise of both images plus propagated inverse-depth noise.
/// @param intensity  σ_h² + e^{2a} σ_t² · factor; the paper has 2 σ_I²
template <typename S>
RAYLIGN_ALWAYS_INLINE S photometric_variance(S intensity, S d_r_d_D, S V) {
  return intensity + d_r_d_D * d_r_d_D * V;
}

/// ∂r/∂ξ (6) for the left perturbation T_th ← exp(ξ) T_th, ξ = [υ; ω]. The seventh entry, of
/// Sim(3)'s σ, is zero: intensities do not see scale.
/// @param g_u, g_v  e^a ∇I_t(p'), grey / px
template <typename S>
RAYLIGN_ALWAYS_INLINE void photometric_jacobian(
    const WarpedPoint<S>& p, const WarpPose<S>& T, S g_u, S g_v, S* J) {
  const S G_x = T.fx * g_u;
  const S G_y = T.fy * g_v;
  const S radial = p.x * G_x + p.y * G_y;
  J[0] = -(G_x * p.inverse_z);
  J[1] = -(G_y * p.inverse_z);
  J[2] = radial * p.inverse_z;
  J[3] = p.y * radial + G_y;
  J[4] = -(p.x * radial + G_x);
  J[5] = p.y * G_x - p.x * G_y;
}

/// r_d = 1/Z' − D_t(p').
template <typename S>
RAYLIGN_ALWAYS_INLINE S depth_residual(const WarpedPoint<S>& p, S D_t) {
  return p.inverse_z - D_t;
}

/// ∂r_d/∂D of the keyframe's inverse depth: (Z' − t_z) / (Z'² D) − ∇D_t · ∂p'/∂D.
/// @param d_u, d_v  ∇D_t(p'); zero leaves the second term out
template <typename S>
RAYLIGN_ALWAYS_INLINE S depth_d_inverse_depth(
    const WarpedPoint<S>& p, const WarpPose<S>& T, const EpipolarStep<S>& step, S d_u, S d_v) {
  const S of_z = (S(1) - T.t[2] * p.inverse_z) * p.inverse_q;
  return of_z - (d_u * step.u + d_v * step.v);
}

/// σ_d² = V_t(p') + (∂r_d/∂D)² V(p).
template <typename S>
RAYLIGN_ALWAYS_INLINE S depth_variance(S V_t, S d_rd_d_D, S V) {
  return V_t + d_rd_d_D * d_rd_d_D * V;
}

/// ∂r_d/∂ξ (7) for the left perturbation, ξ = [υ; ω; σ]: that of 1/Z' less ∇D_t · ∂p'/∂ξ.
/// @param d_u, d_v  ∇D_t(p'); zero leaves the second term out
template <typename S>
RAYLIGN_ALWAYS_INLINE void depth_jacobian(
    const WarpedPoint<S>& p, const WarpPose<S>& T, S d_u, S d_v, S* J) {
  photometric_jacobian(p, T, d_u, d_v, J);  // −∇D_t · ∂p'/∂ξ
  J[2] -= p.inverse_z * p.inverse_z;
  J[3] -= p.inverse_z * p.y;
  J[4] += p.inverse_z * p.x;
  J[6] = -p.inverse_z;
}

}  // namespace raylign
