// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "raylign/base/eigen.h"
#include "raylign/camera/bearing.h"

namespace raylign {

/// The BAL projection for any scalar (double, ceres::Jet): params = (f, k1, k2).
template <typename T>
void bal_project(const T* params, const T* p_c, T* uv) {
  const T x = -p_c[0] / p_c[2];
  const T y = -p_c[1] / p_c[2];
  const T r2 = x * x + y * y;
  const T scale = params[0] * (T(1.0) + r2 * (params[1] + r2 * params[2]));
  uv[0] = scale * x;
  uv[1] = scale * y;
}

/// Camera of Bundle Adjustment in the Large (Agarwal et al., ECCV 2010): looks along −z, v up,
/// principal point at the origin:  p = −P_xy / P_z,  (u, v) = f (1 + k1 ‖p‖² + k2 ‖p‖⁴) p.
class BalCamera {
 public:
  static constexpr int kNumParams = 3;
  static constexpr double kViewZ = -1.0;  ///< looks along −z
  using Params = Eigen::Matrix<double, kNumParams, 1>;

  /// f in px. Nothing is checked here (see validate): a solver may pass through any values.
  BalCamera(double f, double k1, double k2) : f_(f), k1_(k1), k2_(k2) {}
  explicit BalCamera(const Params& params) : BalCamera(params[0], params[1], params[2]) {}

  double f() const { return f_; }
  double k1() const { return k1_; }
  double k2() const { return k2_; }
  /// (f, k1, k2), the file's order.
  Params params() const { return {f_, k1_, k2_}; }
  /// Throws OptionsError for a value that is not finite or f <= 0.
  void validate() const;

  /// True for points on the side the camera looks at.
  static bool is_in_front(const Vector3& p_c) { return p_c.z() < 0.0; }

  /// Projects p_c, also from behind: the BAL cost has no cheirality test (see is_in_front). False,
  /// with outputs unspecified, when |z| <= kMinDepth (|x| + |y|) or the result is not finite.
  /// Inline: the innermost function of bundle adjustment.
  bool project(const Vector3& p_c,
               Vector2& uv,
               RowMajor<2, 3>* J_point = nullptr,
               RowMajor<2, kNumParams>* J_params = nullptr) const;

  /// Unit bearing, z < 0, of pixel uv, by Newton's method; Jacobians by the implicit function
  /// theorem. False when uv lies outside the image of the one-to-one part of the distortion.
  bool unproject(const Vector2& uv,
                 Vector3& bearing,
                 RowMajor<3, 2>* J_uv = nullptr,
                 RowMajor<3, kNumParams>* J_params = nullptr) const;

 private:
  double f_;
  double k1_;
  double k2_;
};

inline bool BalCamera::project(const Vector3& p_c,
                               Vector2& uv,
                               RowMajor<2, 3>* J_point,
                               RowMajor<2, kNumParams>* J_params) const {
  // Relative: a multiple of p_c is the same viewing ray, and homogeneous points come in any scale.
  if (!(std::abs(p_c.z()) > kMinDepth * (std::abs(p_c.x()) + std::abs(p_c.y())))) return false;
  const double w = -1.0 / p_c.z();
  const double x = p_c.x() * w;
  const double y = p_c.y() * w;
  const double r2 = x * x + y * y;
  const double distortion = 1.0 + r2 * (k1_ + r2 * k2_);
  const double fd = f_ * distortion;
  uv = Vector2(fd * x, fd * y);
  if (J_point != nullptr) {
    // d(uv)/dp = f (d I + 2 (k1 + 2 k2 r²) p pᵀ) and dp/dP = w [I | p], w = −1 / P_z.
    const double g = 2.0 * f_ * (k1_ + 2.0 * k2_ * r2) * w;
    const double a = fd * w;
    const double radial = a + g * r2;
    *J_point << a + g * x * x, g * x * y, radial * x,  //
        g * x * y, a + g * y * y, radial * y;
  }
  if (J_params != nullptr) {
    const double fr2 = f_ * r2;
    const double fr4 = fr2 * r2;
    *J_params << distortion * x, fr2 * x, fr4 * x,  //
        distortion * y, fr2 * y, fr4 * y;
  }
  return std::isfinite(uv.x()) && std::isfinite(uv.y());
}

}  // namespace raylign
