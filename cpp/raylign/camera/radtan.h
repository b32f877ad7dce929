// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/camera/pinhole.h"
#include "raylign/camera/polynomial_distortion.h"

namespace raylign {

/// Pinhole behind Brown-Conrady distortion, parameters in OpenCV's order (k1, k2, p1, p2, k3).
/// Looks along +z, x right, y down; (0, 0) is the centre of the first pixel.
class RadtanCamera {
 public:
  static constexpr int kNumParams = 9;
  static constexpr double kViewZ = 1.0;  ///< looks along +z
  using Params = Eigen::Matrix<double, kNumParams, 1>;

  /// (fx, fy, cx, cy) in px, then (k1, k2, p1, p2, k3). Nothing is checked here (see validate).
  RadtanCamera(const PinholeCamera& pinhole, const PolynomialDistortion& distortion);
  explicit RadtanCamera(const Params& params);

  const PinholeCamera& pinhole() const { return pinhole_; }
  const PolynomialDistortion& distortion() const { return distortion_; }
  /// (fx, fy, cx, cy, k1, k2, p1, p2, k3).
  Params params() const;
  /// Throws OptionsError for a value that is not finite or a focal length <= 0.
  void validate() const;

  /// True for points on the side the camera looks at.
  static bool is_in_front(const Vector3& p_c) { return p_c.z() > 0.0; }

  /// False, with outputs unspecified, when z < kMinDepth (behind the camera), not finite, or so far
  /// off the axis that the distortion polynomial folds back
  /// (PolynomialDistortion::max_radius_squared).
  bool project(const Vector3& p_c,
               Vector2& uv,
               RowMajor<2, 3>* J_point = nullptr,
               RowMajor<2, kNumParams>* J_params = nullptr) const;

  /// Unit bearing, z > 0, of pixel uv, by Newton's method; Jacobians by the implicit function
  /// theorem. False when no ray within the one-to-one part of the distortion reaches uv.
  bool unproject(const Vector2& uv,
                 Vector3& bearing,
                 RowMajor<3, 2>* J_uv = nullptr,
                 RowMajor<3, kNumParams>* J_params = nullptr) const;

 private:
  PinholeCamera pinhole_;
  PolynomialDistortion distortion_;
  double max_radius_squared_;
};

}  // namespace raylign
