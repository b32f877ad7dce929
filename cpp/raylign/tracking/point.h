// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "raylign/image/plane.h"
#include "raylign/image/sample.h"
#include "raylign/tracking/kernels.h"

/// The kernel's scalar twin: one point in double. Maps, the Ceres oracle and the kernel's tests use
/// it.
namespace raylign::tracking {

/// Keyframe point, D != NaN.
struct HostPoint {
  double ray_x, ray_y;
  double D, V;
  double I;
  double g_u, g_v;
};

struct PointPose {
  WarpPose<double> pose;
  double gain, b;
};

struct PointResidual {
  double r;
  double variance;  ///< σ²
  double J[8];      ///< photometric: [υ; ω], a, b; depth: [υ; ω; σ]
  double g_u, g_v;  ///< gradient in J
  double sampled;   ///< I_t(p') or D_t(p')
};

inline PointPose point_pose(const PassSettings& s) {
  PointPose p;
  for (int k = 0; k < 9; ++k) p.pose.R[k] = static_cast<double>(s.pose.R[k]);
  for (int k = 0; k < 3; ++k) p.pose.t[k] = static_cast<double>(s.pose.t[k]);
  p.pose.fx = static_cast<double>(s.pose.fx);
  p.pose.fy = static_cast<double>(s.pose.fy);
  p.pose.cx = static_cast<double>(s.pose.cx);
  p.pose.cy = static_cast<double>(s.pose.cy);
  p.gain = static_cast<double>(s.gain);
  p.b = static_cast<double>(s.b);
  return p;
}

inline HostPoint host_point(const PointArrays& arrays, std::int64_t i) {
  return {static_cast<double>(arrays.ray_x[i]), static_cast<double>(arrays.ray_y[i]),
          static_cast<double>(arrays.D[i]),     static_cast<double>(arrays.V[i]),
          static_cast<double>(arrays.I[i]),     static_cast<double>(arrays.g_u[i]),
          static_cast<double>(arrays.g_v[i])};
}

/// In front of the target camera and within the image, as the kernel decides.
inline bool is_in_view(const WarpedPoint<double>& p, int width, int height) {
  return p.inverse_q > 0.0 && p.inverse_q < 1e3 && p.u >= 0.0 && p.u < width - 1 && p.v >= 0.0 &&
         p.v < height - 1;
}

/// Equations 13 and 14 at one point. False: no residual.
inline bool photometric_point(const HostPoint& point,
                              const PlaneView<GradientCell>& target,
                              const PointPose& at,
                              const PassSettings& s,
                              PointResidual& out) {
  const WarpedPoint<double> p = warp(point.ray_x, point.ray_y, point.D, at.pose);
  Sample<double> sample;
  if (!is_in_view(p, target.width, target.height)) return false;
  if (!sample_bilinear(target, p.u, p.v, sample)) return false;
  out.sampled = sample.value;
  out.r = photometric_residual(point.I, sample.value, at.gain, at.b);
  out.g_u = at.gain * sample.du;
  out.g_v = at.gain * sample.dv;
  if (s.esm) {
    const auto c = static_cast<double>(s.roll_cos);
    const auto n = static_cast<double>(s.roll_sin);
    out.g_u = 0.5 * (out.g_u + c * point.g_u - n * point.g_v);
    out.g_v = 0.5 * (out.g_v + n * point.g_u + c * point.g_v);
  }
  const double factor =
      s.exact_noise ? bilinear_noise_factor(p.u - std::floor(p.u), p.v - std::floor(p.v)) : 1.0;
  const double d_r_d_D = photometric_d_inverse_depth(epipolar_step(p, at.pose), out.g_u, out.g_v);
  out.variance = photometric_variance(
      static_cast<double>(s.host_variance) + static_cast<double>(s.target_variance) * factor,
      d_r_d_D, point.V);
  photometric_jacobian(p, at.pose, out.g_u, out.g_v, out.J);
  out.J[6] = -at.gain * sample.value;
  out.J[7] = -1.0;
  return std::isfinite(out.r) && std::isfinite(out.g_u) && std::isfinite(out.g_v);
}

/// The depth residual at one point. False: none.
inline bool depth_point(const HostPoint& point,
                        const PlaneView<DepthCell>& target,
                        const PointPose& at,
                        const PassSettings& s,
                        PointResidual& out) {
  const WarpedPoint<double> p = warp(point.ray_x, point.ray_y, point.D, at.pose);
  if (!is_in_view(p, target.width, target.height)) return false;
  const int u = static_cast<int>(p.u);
  const int v = static_cast<int>(p.v);
  const double f = p.u - u;
  const double g = p.v - v;
  const DepthCell* top = target.row(v) + u;
  const DepthCell* bottom = target.row(v + 1) + u;
  if (!(top->variance > 0.0F)) return false;
  const auto mix = [&](float DepthCell::* member) {
    const auto upper =
        (1.0 - f) * static_cast<double>(top[0].*member) + f * static_cast<double>(top[1].*member);
    const auto lower = (1.0 - f) * static_cast<double>(bottom[0].*member) +
                       f * static_cast<double>(bottom[1].*member);
    return (1.0 - g) * upper + g * lower;
  };
  out.sampled = mix(&DepthCell::D);
  out.g_u = s.depth_gradient ? mix(&DepthCell::du) : 0.0;
  out.g_v = s.depth_gradient ? mix(&DepthCell::dv) : 0.0;
  out.r = depth_residual(p, out.sampled);
  if (!(std::abs(out.r) <= s.depth_gate * out.sampled)) return false;
  const double d_r_d_D =
      depth_d_inverse_depth(p, at.pose, epipolar_step(p, at.pose), out.g_u, out.g_v);
  out.variance = depth_variance(static_cast<double>(top->variance), d_r_d_D, point.V);
  depth_jacobian(p, at.pose, out.g_u, out.g_v, out.J);
  out.J[7] = 0.0;
  return std::isfinite(out.r);
}

}  // namespace raylign::tracking
