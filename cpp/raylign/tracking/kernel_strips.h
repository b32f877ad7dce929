// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "raylign/base/clones.h"
#include "raylign/tracking/kernels.h"

/// Residuals, variances and weights over a strip of points; part of kernels.cpp, which alone
/// includes it. Loops over contiguous arrays that the compiler vectorises.
namespace raylign::tracking {

// As many points as keep the buffers below in the first-level cache.
constexpr int kStrip = 128;
// q_z > 1 / kMaxInverseQ: a point must not come nearer than that fraction of its depth.
constexpr float kMaxInverseQ = 1e3F;
constexpr float kGoodConstant = 1600.0F;  // LSD-SLAM: r² < 40² + |∇I|² / 4
constexpr float kGoodGradient = 0.25F;
constexpr float kAgreement = 9.0F;  // within three sigma
constexpr int kPartnerShift = 5;

typedef float Lanes __attribute__((vector_size(32), may_alias));
typedef float Cell __attribute__((vector_size(16), may_alias));

RAYLIGN_INLINE const Lanes& load(const float* values) {
  return *reinterpret_cast<const Lanes*>(values);
}

// Groups of kLanes start at multiples of 32 bytes.
RAYLIGN_INLINE const float* aligned(const float* values) {
  return static_cast<const float*>(__builtin_assume_aligned(values, 32));
}

RAYLIGN_INLINE double sum_lanes(const Lanes& lanes) {
  double sum = 0.0;
  for (int k = 0; k < kLanes; ++k) sum += static_cast<double>(lanes[k]);
  return sum;
}

// Where the points of a strip land. `ok`: in front of the camera and within the image.
struct Warped {
  WarpPose<float> pose;
  alignas(32) float x[kStrip], y[kStrip], inverse_q[kStrip], inverse_z[kStrip];
  alignas(32) float f[kStrip], g[kStrip];  // sub-pixel phase
  alignas(32) std::int32_t cell[kStrip];
  alignas(32) std::int32_t ok[kStrip];
};

// Cells of the target, interpolated; `corner` is the fourth number of the upper left one.
struct Sampled {
  alignas(32) float value[kStrip], du[kStrip], dv[kStrip], corner[kStrip];
};

// The residual of one term over a strip, then its weight and Jacobian. Points without a residual
// have r, precision, w and J of zero.
struct Residuals {
  alignas(32) float r[kStrip], precision[kStrip];
  alignas(32) float g_u[kStrip], g_v[kStrip];
  alignas(32) float n2[kStrip], n2_reference[kStrip];
  alignas(32) float rho[kStrip], rho_reference[kStrip], d_rho[kStrip];
  alignas(32) float w[kStrip], wr[kStrip];
  alignas(32) float count[kStrip];  // 1 or 0
  alignas(32) std::int32_t ok[kStrip];
  alignas(32) float J[kMaxColumns][kStrip];
};

// Float sums of a pass, one lane per point modulo kLanes; added up in double at its end.
struct TermLanes {
  Lanes H[kMaxTriangle];
  Lanes g[kMaxColumns];
  Lanes rho, rho_reference, count, weight, weighted_square;
};

RAYLIGN_INLINE WarpedPoint<float> point_of(const Warped& warped, int i) {
  return {warped.x[i], warped.y[i], warped.inverse_q[i], warped.inverse_z[i], 0.0F, 0.0F};
}

RAYLIGN_INLINE void warp_strip(
    const PointArrays& points, const TargetArrays& target, std::int64_t begin, int n, Warped& out) {
  const float u_end = static_cast<float>(target.width - 1);
  const float v_end = static_cast<float>(target.height - 1);
  const float* ray_x = aligned(points.ray_x + begin);
  const float* ray_y = aligned(points.ray_y + begin);
  const float* D = aligned(points.D + begin);
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const WarpedPoint<float> p = warp(ray_x[i], ray_y[i], D[i], out.pose);
    // written so that NaN fails
    const bool ok = (p.inverse_q > 0.0F) & (p.inverse_q < kMaxInverseQ) & (p.u >= 0.0F) &
                    (p.u < u_end) & (p.v >= 0.0F) & (p.v < v_end);
    const float u = ok ? p.u : 0.0F;
    const float v = ok ? p.v : 0.0F;
    const auto u0 = static_cast<std::int32_t>(u);
    const auto v0 = static_cast<std::int32_t>(v);
    out.x[i] = p.x;
    out.y[i] = p.y;
    out.inverse_q[i] = p.inverse_q;
    out.inverse_z[i] = p.inverse_z;
    out.f[i] = u - static_cast<float>(u0);
    out.g[i] = v - static_cast<float>(v0);
    out.cell[i] = v0 * target.width + u0;
    out.ok[i] = ok ? 1 : 0;
  }
}

// A cell and the one to its right.
typedef float CellPair __attribute__((vector_size(32), aligned(16), may_alias));

RAYLIGN_INLINE Cell interpolate(const CellPair* top, const CellPair* bottom, float f, float g) {
  const CellPair column = *top + g * (*bottom - *top);
  const Cell left = __builtin_shufflevector(column, column, 0, 1, 2, 3);
  const Cell right = __builtin_shufflevector(column, column, 4, 5, 6, 7);
  return left + f * (right - left);
}

// Bilinear interpolation of whole cells, four points at a time, then their transpose.
template <bool WithCorner>
RAYLIGN_INLINE void sample_strip(
    const float* cells, int width, const Warped& warped, int n, Sampled& out) {
  const auto* all = reinterpret_cast<const Cell*>(cells);
  for (int i = 0; i < n; i += 4) {
    Cell point[4];
    for (int k = 0; k < 4; ++k) {
      const Cell* top = all + warped.cell[i + k];
      const Cell* bottom = top + width;
      point[k] =
          interpolate(reinterpret_cast<const CellPair*>(top),
                      reinterpret_cast<const CellPair*>(bottom), warped.f[i + k], warped.g[i + k]);
      if constexpr (WithCorner) out.corner[i + k] = (*top)[3];
    }
    const Cell a01 = __builtin_shufflevector(point[0], point[1], 0, 4, 1, 5);
    const Cell a23 = __builtin_shufflevector(point[2], point[3], 0, 4, 1, 5);
    const Cell b01 = __builtin_shufflevector(point[0], point[1], 2, 6, 3, 7);
    const Cell b23 = __builtin_shufflevector(point[2], point[3], 2, 6, 3, 7);
    *reinterpret_cast<Cell*>(out.value + i) = __builtin_shufflevector(a01, a23, 0, 1, 4, 5);
    *reinterpret_cast<Cell*>(out.du + i) = __builtin_shufflevector(a01, a23, 2, 3, 6, 7);
    *reinterpret_cast<Cell*>(out.dv + i) = __builtin_shufflevector(b01, b23, 0, 1, 4, 5);
  }
}

RAYLIGN_INLINE bool is_finite(float value) { return value - value == 0.0F; }

// r, ∇I and 1/σ_r² (eq. 13, 14).
RAYLIGN_INLINE void photometric_strip(const PointArrays& points,
                                      const PassSettings& settings,
                                      const Warped& warped,
                                      const Sampled& sampled,
                                      std::int64_t begin,
                                      int n,
                                      Residuals& out) {
  const float* I = aligned(points.I + begin);
  const float* V = aligned(points.V + begin);
  const float* h_u = aligned(points.g_u + begin);
  const float* h_v = aligned(points.g_v + begin);
  const float gain = settings.gain;
  const float b = settings.b;
  const float host_variance = settings.host_variance;
  const float target_variance = settings.target_variance;
  const float own = settings.esm ? 0.5F : 1.0F;
  const float rolled = settings.esm ? 0.5F : 0.0F;
  const float exact = settings.exact_noise ? 1.0F : 0.0F;
  const float c = rolled * settings.roll_cos;
  const float s = rolled * settings.roll_sin;
  const WarpPose<float> pose = warped.pose;
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float r = photometric_residual(I[i], sampled.value[i], gain, b);
    const float g_u = own * gain * sampled.du[i] + (c * h_u[i] - s * h_v[i]);
    const float g_v = own * gain * sampled.dv[i] + (s * h_u[i] + c * h_v[i]);
    const WarpedPoint<float> p = point_of(warped, i);
    const float d_r_d_D = photometric_d_inverse_depth(epipolar_step(p, pose), g_u, g_v);
    const float factor = 1.0F + exact * (bilinear_noise_factor(warped.f[i], warped.g[i]) - 1.0F);
    const float variance =
        photometric_variance(host_variance + target_variance * factor, d_r_d_D, V[i]);
    const bool ok = (warped.ok[i] != 0) & is_finite(r) & is_finite(g_u) & is_finite(g_v);
    out.ok[i] = ok ? 1 : 0;
    out.count[i] = ok ? 1.0F : 0.0F;
    out.r[i] = ok ? r : 0.0F;
    out.g_u[i] = ok ? g_u : 0.0F;
    out.g_v[i] = ok ? g_v : 0.0F;
    out.precision[i] = ok ? 1.0F / variance : 0.0F;
  }
}

// r_d and 1/σ_d².
RAYLIGN_INLINE void depth_strip(const PointArrays& points,
                                const PassSettings& settings,
                                const Warped& warped,
                                const Sampled& sampled,
                                std::int64_t begin,
                                int n,
                                Residuals& out) {
  const float* V = aligned(points.V + begin);
  const float slope = settings.depth_gradient ? 1.0F : 0.0F;
  const float gate = settings.depth_gate;
  const WarpPose<float> pose = warped.pose;
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const WarpedPoint<float> p = point_of(warped, i);
    const float d_u = slope * sampled.du[i];
    const float d_v = slope * sampled.dv[i];
    const float r = depth_residual(p, sampled.value[i]);
    const float limit = gate * sampled.value[i];  // NaN stays out, too
    const float d_r_d_D = depth_d_inverse_depth(p, pose, epipolar_step(p, pose), d_u, d_v);
    const float V_t = sampled.corner[i];
    const bool ok = (warped.ok[i] != 0) & (V_t > 0.0F) & (r <= limit) & (-r <= limit);
    const float variance = depth_variance(V_t, d_r_d_D, V[i]);
    out.ok[i] = ok ? 1 : 0;
    out.count[i] = ok ? 1.0F : 0.0F;
    out.r[i] = ok ? r : 0.0F;
    out.g_u[i] = d_u;
    out.g_v[i] = d_v;
    out.precision[i] = ok ? 1.0F / variance : 0.0F;
  }
}

// n² = r² / (scale σ)² at this pose's and at the reference's σ; the 1/σ² that count are left in
// `precision`.
RAYLIGN_INLINE void normalise_strip(
    const float* reference, bool freeze, float scale, int n, Residuals& out) {
  const float shrink = 1.0F / (scale * scale);
  if (reference == nullptr) {
    for (int i = 0; i < n; ++i) {
      out.n2[i] = shrink * (out.r[i] * out.r[i]) * out.precision[i];
      out.n2_reference[i] = out.n2[i];
    }
    return;
  }
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float r2 = shrink * (out.r[i] * out.r[i]);
    const float own = out.precision[i];
    const float known = reference[i] > 0.0F ? reference[i] : own;
    const float chosen = freeze & (out.ok[i] != 0) ? known : own;
    out.precision[i] = chosen;
    out.n2[i] = r2 * chosen;
    out.n2_reference[i] = r2 * known;
  }
}

RAYLIGN_INLINE void huber_strip(float delta, int n, Residuals& out) {
  const float d2 = delta * delta;
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float s = out.n2[i];
    const float s_reference = out.n2_reference[i];
    // the root of at least d2, so that 1 / root is finite in both branches
    const float root = std::sqrt(s > d2 ? s : d2);
    const float root_reference = std::sqrt(s_reference > d2 ? s_reference : d2);
    out.rho[i] = s <= d2 ? s : 2.0F * delta * root - d2;
    out.d_rho[i] = delta / root;
    out.rho_reference[i] = s_reference <= d2 ? s_reference : 2.0F * delta * root_reference - d2;
  }
}

RAYLIGN_INLINE void trivial_strip(int n, Residuals& out) {
  for (int i = 0; i < n; ++i) {
    out.rho[i] = out.n2[i];
    out.rho_reference[i] = out.n2_reference[i];
    out.d_rho[i] = 1.0F;
  }
}

RAYLIGN_INLINE void loss_strip(const Loss& loss, int n, Residuals& out) {
  if (loss.type == LossType::HUBER) return huber_strip(static_cast<float>(loss.scale), n, out);
  if (loss.type == LossType::TRIVIAL) return trivial_strip(n, out);
  for (int i = 0; i < n; ++i) {
    const LossValue value = loss.evaluate(static_cast<double>(out.n2[i]));
    out.rho[i] = static_cast<float>(value.rho);
    out.d_rho[i] = static_cast<float>(value.d_rho);
    out.rho_reference[i] =
        static_cast<float>(loss.evaluate(static_cast<double>(out.n2_reference[i])).rho);
  }
}

// w = ρ′ / (scale σ)².
RAYLIGN_INLINE void weigh_strip(float scale, int n, Residuals& out) {
  const float shrink = 1.0F / (scale * scale);
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float w = shrink * out.d_rho[i] * out.precision[i];
    out.w[i] = w;
    out.wr[i] = w * out.r[i];
    out.d_rho[i] *= out.count[i];
  }
}

}  // namespace raylign::tracking
