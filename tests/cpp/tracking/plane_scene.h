// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>

#include "raylign/geometry/se3.h"
#include "raylign/tracking/aligner.h"

namespace raylign::test {

/// A slanted plane with a texture of sines, seen by a pinhole: image and inverse depth are exact.
struct PlaneScene {
  int width = 160;
  int height = 120;
  double frequency = 1.0;  ///< of the texture, relative
  double scale = 1.0;      ///< of the world

  PinholeCamera camera() const {
    return {0.82 * width, 0.82 * width, 0.5 * (width - 1), 0.5 * (height - 1)};
  }
  double texture(double x, double y) const {
    x *= frequency / scale;
    y *= frequency / scale;
    return 128.0 + 35.0 * std::sin(10.0 * x) + 30.0 * std::cos(9.0 * y) +
           25.0 * std::sin(6.0 * x + 8.0 * y) + 15.0 * std::sin(22.0 * x - 15.0 * y);
  }
  /// T_th: host to this view.
  void render(const Matrix4& T_th, Plane<float>& image, Plane<float>& D) const {
    const PinholeCamera K = camera();
    const Matrix4 T_ht = se3_inverse(T_th);
    const Matrix3 R = T_ht.topLeftCorner<3, 3>();
    const Vector3 t = T_ht.topRightCorner<3, 1>();
    const Vector3 normal(-0.3, 0.1, 1.0);
    image.resize(width, height);
    D.resize(width, height);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const Vector3 ray = R * Vector3((u - K.cx()) / K.fx(), (v - K.cy()) / K.fy(), 1.0);
        const double depth = (2.0 * scale - normal.dot(t)) / normal.dot(ray);
        const Vector3 X = t + depth * ray;
        image.at(u, v) = static_cast<float>(texture(X.x(), X.y()));
        D.at(u, v) = static_cast<float>(1.0 / depth);
      }
    }
  }
  std::shared_ptr<Frame> frame(const Matrix4& T_th, double variance = 0.0) const {
    Plane<float> image, D;
    render(T_th, image, D);
    return frame_of(image, D, variance);
  }
  /// Without depth when `variance` is zero.
  std::shared_ptr<Frame> frame_of(const Plane<float>& image,
                                  const Plane<float>& D,
                                  double variance) const {
    auto frame = std::make_shared<Frame>(view_of(image), camera());
    if (variance > 0.0) {
      Plane<float> V(width, height);
      std::fill(V.data(), V.data() + V.size(), static_cast<float>(variance));
      frame->set_depth(D.view(), V.view());
    }
    return frame;
  }
  static ImageView view_of(const Plane<float>& image) {
    return {image.data(),
            PixelType::FLOAT32,
            image.width(),
            image.height(),
            1,
            sizeof(float) * static_cast<std::size_t>(image.width())};
  }
};

/// Left-perturbation error log(T_est T_true⁻¹).
inline Vector6 pose_error(const Matrix4& estimate, const Matrix4& truth) {
  return se3_log(estimate * se3_inverse(truth));
}

}  // namespace raylign::test
