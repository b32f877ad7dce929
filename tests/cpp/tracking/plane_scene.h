// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>

#include "raylign/geometry/se3.h"
#include "raylign/tracking/aligner.h"

namespace raylign::test {

/// The inside of a corner of slanted planes with a texture of sines, seen by a pinhole: image and
/// inverse depth are exact, nothing is hidden.
struct PlaneScene {
  int width = 160;
  int height = 120;
  double frequency = 1.0;  ///< of the texture, relative
  double scale = 1.0;      ///< of the world

  PinholeCamera camera() const {
    return {0.82 * width, 0.82 * width, 0.5 * (width - 1), 0.5 * (height - 1)};
  }
  double texture(const Vector3& X) const {
    const Vector3 p = X * (frequency / scale);
    return 128.0 + 35.0 * std::sin(9.0 * p.x() + 2.0 * p.z()) +
           30.0 * std::cos(8.0 * p.y() - 3.0 * p.z()) + 25.0 * std::sin(6.0 * p.x() + 8.0 * p.y()) +
           15.0 * std::sin(20.0 * p.x() - 15.0 * p.y() + 5.0 * p.z());
  }
  /// Depth along a ray from t: the nearest plane n · X = d.
  double depth(const Vector3& t, const Vector3& ray) const {
    const double planes[][4] = {{-0.3, 0.1, 1.0, 2.2},
                                {0.75, 0.1, 0.65, 1.9},
                                {-0.8, 0.1, 0.55, 1.7},
                                {0.05, 0.85, 0.5, 1.7}};
    double nearest = 1e9;
    for (const auto& p : planes) {
      const Vector3 n(p[0], p[1], p[2]);
      const double z = (p[3] * scale - n.dot(t)) / n.dot(ray);
      if (z > 0.0 && z < nearest) nearest = z;
    }
    return nearest;
  }
  /// T_th: host to this view, of its middle row; row s (tracking/shutter.h) is seen from
  /// exp(s sweep) T_th.
  void render(const Matrix4& T_th,
              Plane<float>& image,
              Plane<float>& D,
              const Vector6& sweep = Vector6::Zero()) const {
    const PinholeCamera K = camera();
    image.resize(width, height);
    D.resize(width, height);
    for (int v = 0; v < height; ++v) {
      const Matrix4 T_ht = se3_inverse(se3_exp(((v + 0.5) / height - 0.5) * sweep) * T_th);
      const Matrix3 R = T_ht.topLeftCorner<3, 3>();
      const Vector3 t = T_ht.topRightCorner<3, 1>();
      for (int u = 0; u < width; ++u) {
        const Vector3 ray = R * Vector3((u - K.cx()) / K.fx(), (v - K.cy()) / K.fy(), 1.0);
        const double z = depth(t, ray);
        image.at(u, v) = static_cast<float>(texture(t + z * ray));
        D.at(u, v) = static_cast<float>(1.0 / z);
      }
    }
  }
  std::shared_ptr<Frame> frame(const Matrix4& T_th,
                               double variance = 0.0,
                               const Vector6& sweep = Vector6::Zero()) const {
    Plane<float> image, D;
    render(T_th, image, D, sweep);
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
