// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

namespace raylign {

/// Pinhole without distortion: u = fx x / z + cx, v = fy y / z + cy. Looks along +z, x right, y
/// down; (0, 0) is the centre of the first pixel.
class PinholeCamera {
 public:
  static constexpr int kNumParams = 4;
  static constexpr double kViewZ = 1.0;  ///< looks along +z
  using Params = Eigen::Matrix<double, kNumParams, 1>;

  /// All in px. Nothing is checked here (see validate).
  PinholeCamera(double fx, double fy, double cx, double cy) : fx_(fx), fy_(fy), cx_(cx), cy_(cy) {}
  explicit PinholeCamera(const Params& params)
      : PinholeCamera(params[0], params[1], params[2], params[3]) {}

  double fx() const { return fx_; }
  double fy() const { return fy_; }
  double cx() const { return cx_; }
  double cy() const { return cy_; }
  /// (fx, fy, cx, cy).
  Params params() const { return {fx_, fy_, cx_, cy_}; }
  /// [fx 0 cx; 0 fy cy; 0 0 1].
  Matrix3 matrix() const;
  /// Throws OptionsError for a value that is not finite or a focal length <= 0.
  void validate() const;

  /// The camera of level `level` >= 0 of an ImagePyramid: f / 2^l and c_l = (c + 1/2) / 2^l - 1/2,
  /// because a 2x2 box mean lies half a pixel beside the first of its four. Throws OptionsError for
  /// a negative level.
  PinholeCamera at_level(int level) const;

  /// True for points on the side the camera looks at.
  static bool is_in_front(const Vector3& p_c) { return p_c.z() > 0.0; }

  /// False, with outputs unspecified, when z < kMinDepth (behind the camera) or not finite.
  bool project(const Vector3& p_c,
               Vector2& uv,
               RowMajor<2, 3>* J_point = nullptr,
               RowMajor<2, kNumParams>* J_params = nullptr) const;

  /// Unit bearing, z > 0, of pixel uv. False when uv is not finite.
  bool unproject(const Vector2& uv,
                 Vector3& bearing,
                 RowMajor<3, 2>* J_uv = nullptr,
                 RowMajor<3, kNumParams>* J_params = nullptr) const;

 private:
  double fx_;
  double fy_;
  double cx_;
  double cy_;
};

}  // namespace raylign
