// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/base/random.h"
#include "raylign/synthetic/bal_options.h"

namespace raylign {

using Rgb = std::array<std::uint8_t, 3>;

/// True camera of a synthetic scene, BAL axes: x right, y up, looks along −z.
struct SceneCamera {
  Matrix3 R_cw;                      ///< exp(omega)
  Vector3 t_cw;                      ///< m
  Vector3 center;                    ///< −R_cwᵀ t_cw, m
  Vector3 omega;                     ///< rotation vector of R_cw, rad
  std::array<double, 3> intrinsics;  ///< f, k1, k2
  int lap = 0;                       ///< pass over the same place; others are matched less often
};

/// A point on a surface of the scene.
struct ScenePoint {
  Vector3 position = Vector3::Zero();  ///< world frame, m
  Vector3 normal = Vector3::Zero();    ///< unit; zero: seen from every side
  Rgb color{};
  int region = -1;     ///< the scene's own label, for line_of_sight
  double reach = 0.0;  ///< farthest camera that matches it, m; infinite: no occlusion either
};

/// Cameras and surfaces, z up. Sampling is a pure function of the stream handed in.
class BalScene {
 public:
  virtual ~BalScene() = default;

  const std::vector<SceneCamera>& cameras() const { return cameras_; }
  /// Distance between neighbouring cameras, m.
  double baseline() const { return baseline_; }
  /// Distance at which most points are seen, m.
  double viewing_distance() const { return viewing_distance_; }

  /// Draws a surface point roughly in view of the camera; false when the draw hits nothing.
  virtual bool sample(int camera, RandomStream& random, ScenePoint& point) const = 0;
  /// False when another surface stands between the camera's centre and the point.
  virtual bool line_of_sight(int camera, const ScenePoint& point) const = 0;

 protected:
  /// Cameras from poses; intrinsics from the streams ("intrinsics", camera).
  void add_camera(const SyntheticBalOptions& options,
                  const Vector3& center,
                  const Vector3& forward,
                  double roll,
                  int lap);

  double baseline_ = 1.0;
  double viewing_distance_ = 10.0;

 private:
  std::vector<SceneCamera> cameras_;
};

/// The scene that `options.kind` names. Throws OptionsError through validate().
std::unique_ptr<BalScene> make_bal_scene(const SyntheticBalOptions& options);

/// exp(ω), by the portable sine and cosine.
Matrix3 portable_so3_exp(const Vector3& omega);
/// Its inverse, ‖ω‖ <= π.
Vector3 portable_so3_log(const Matrix3& R);

/// Normalised coordinates P_xy / −P_z of a uniform pixel of the camera; false when it lands
/// outside.
bool sample_direction(const SyntheticBalOptions& options,
                      const SceneCamera& camera,
                      RandomStream& random,
                      Vector3& direction_w);

/// 32 well-mixed bits of up to three small integers: colours and heights of buildings, trees,
/// stones.
std::uint32_t hash_cell(std::int64_t a, std::int64_t b = 0, std::int64_t c = 0);
/// The same as a number in [0, 1).
double hash_unit(std::int64_t a, std::int64_t b = 0, std::int64_t c = 0);

/// `base` scaled by `brightness`, with a little noise from `random`, clamped.
Rgb shade(const Rgb& base, double brightness, RandomStream& random);

}  // namespace raylign
