// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/bal_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "raylign/base/portable_math.h"
#include "raylign/camera/bal.h"
#include "raylign/synthetic/orbit_scene.h"
#include "raylign/synthetic/street_scene.h"

namespace raylign {
namespace {

double clamped_normal(RandomStream& random) {
  return std::clamp(random.normal(), -kMaxCameraSigmas, kMaxCameraSigmas);
}

// Rows of R_cw: right, up, back (BAL looks along −z).
Matrix3 look_along(const Vector3& forward, double roll) {
  const Vector3 back = -forward.normalized();
  const Vector3 level_right = forward.cross(Vector3::UnitZ()).normalized();
  const Vector3 level_up = back.cross(level_right);
  const auto [s, c] = portable::sincos(roll);
  Matrix3 R_cw;
  R_cw << (c * level_right + s * level_up).transpose(),
      (c * level_up - s * level_right).transpose(), back.transpose();
  return R_cw;
}

}  // namespace

// Through the quaternion, whose largest component Eigen divides by (Shepperd 1978): good near π.
Vector3 portable_so3_log(const Matrix3& R) {
  const Eigen::Quaterniond q(R);
  const double norm = q.vec().norm();
  if (norm < 1e-12) return Vector3::Zero();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double angle = 2.0 * portable::atan2(norm, sign * q.w());
  return (sign * angle / norm) * q.vec();
}

Matrix3 portable_so3_exp(const Vector3& omega) {
  const double angle = omega.norm();
  if (angle < 1e-12) return Matrix3::Identity();
  const Vector3 a = omega / angle;
  const auto [s, c] = portable::sincos(angle);
  Matrix3 K;
  K << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return c * Matrix3::Identity() + s * K + (1.0 - c) * (a * a.transpose());  // Rodrigues
}

void BalScene::add_camera(const SyntheticBalOptions& options,
                          const Vector3& center,
                          const Vector3& forward,
                          double roll,
                          int lap) {
  SceneCamera camera;
  camera.omega = portable_so3_log(look_along(forward, roll));
  camera.R_cw = portable_so3_exp(camera.omega);
  camera.t_cw = -(camera.R_cw * center);
  camera.center = -(camera.R_cw.transpose() * camera.t_cw);
  camera.lap = lap;
  RandomStream random(options.seed, "intrinsics", cameras_.size());
  camera.intrinsics[0] = options.focal * (1.0 + options.focal_sigma * clamped_normal(random));
  camera.intrinsics[1] = options.k1 + options.k1_sigma * clamped_normal(random);
  camera.intrinsics[2] = options.k2 + options.k2_sigma * clamped_normal(random);
  cameras_.push_back(camera);
}

std::unique_ptr<BalScene> make_bal_scene(const SyntheticBalOptions& options) {
  options.validate();
  if (options.kind == SyntheticBalKind::ORBIT) return std::make_unique<OrbitScene>(options);
  return std::make_unique<StreetScene>(options);
}

bool sample_direction(const SyntheticBalOptions& options,
                      const SceneCamera& camera,
                      RandomStream& random,
                      Vector3& direction_w) {
  const double half_width = 0.5 * options.image_width;
  const double half_height = 0.5 * options.image_height;
  const double x = random.uniform(-1.05, 1.05) * half_width / camera.intrinsics[0];
  const double y = random.uniform(-1.05, 1.05) * half_height / camera.intrinsics[0];
  const double p_c[3] = {x, y, -1.0};
  double uv[2];
  bal_project(camera.intrinsics.data(), p_c, uv);
  direction_w = camera.R_cw.transpose() * Vector3(x, y, -1.0);
  return std::abs(uv[0]) <= half_width && std::abs(uv[1]) <= half_height;
}

std::uint32_t hash_cell(std::int64_t a, std::int64_t b, std::int64_t c) {
  std::uint64_t mix = static_cast<std::uint64_t>(a);
  mix = splitmix64(mix) ^ static_cast<std::uint64_t>(b);
  mix = splitmix64(mix) ^ static_cast<std::uint64_t>(c);
  return static_cast<std::uint32_t>(splitmix64(mix) >> 32);
}

double hash_unit(std::int64_t a, std::int64_t b, std::int64_t c) {
  return hash_cell(a, b, c) * 0x1.0p-32;
}

Rgb shade(const Rgb& base, double brightness, RandomStream& random) {
  const double factor = brightness * random.uniform(0.92, 1.08);
  Rgb color;
  for (int i = 0; i < 3; ++i) {
    color[i] = static_cast<std::uint8_t>(std::clamp(base[i] * factor, 0.0, 255.0));
  }
  return color;
}

}  // namespace raylign
