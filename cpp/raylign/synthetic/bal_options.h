// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace raylign {

/// What is photographed, and how.
enum class SyntheticBalKind {
  STREET,  ///< a car with a camera rig drives laps through a city: facades, trees, road; loop
           ///< closures
  ORBIT,   ///< a photo collection around a domed rotunda on a plaza: rings of cameras looking
           ///< inwards
};

/// Options of the synthetic Bundle-Adjustment-in-the-Large generator. Scene units are metres;
/// everything follows from `seed` alone and every knob has its own random stream: turning one
/// leaves the others' draws.
struct SyntheticBalOptions {
  SyntheticBalKind kind = SyntheticBalKind::STREET;
  int num_cameras = 100;  ///< >= 2.
  std::int64_t num_points =
      10000;  ///< >= 4 · num_cameras (each camera starts at least two of them).
  std::int64_t num_observations = 0;  ///< Exact total, >= 2 · num_points; 0: by mean_track_length.
  double mean_track_length =
      4.5;                 ///< Observations per point, >= 2; Lomax tail. Less if too few see it.
  std::uint64_t seed = 0;  ///< Everything is a function of it.

  int num_laps = 2;           ///< STREET: times the loop is driven, >= 1.
  int views_per_stop = 4;     ///< STREET: cameras of the rig, 45° apart (360°/n above 8), >= 1.
  double stop_spacing = 2.0;  ///< STREET: metres between stops, > 0; more when the loop is short.
  double loop_closure_fraction = 0.3;  ///< STREET: points that are matched across laps, in [0, 1].
  double max_distance = 60.0;          ///< Farthest matched facade, tree or ground, in m, > 0.

  int image_width = 640;      ///< Pixels, >= 16; observations have |u| <= width / 2.
  int image_height = 480;     ///< Pixels, >= 16; observations have |v| <= height / 2.
  double focal = 500.0;       ///< Mean focal length in px, > 0.
  double focal_sigma = 0.03;  ///< Its relative spread over the cameras, in [0, 0.3].
  double k1 = -0.06;        ///< Mean radial distortion, r² term; must stay invertible in the image.
  double k1_sigma = 0.02;   ///< Its spread over the cameras, >= 0.
  double k2 = 0.01;         ///< Mean radial distortion, r⁴ term.
  double k2_sigma = 0.005;  ///< Its spread over the cameras, >= 0.

  double far_fraction =
      0.0;  ///< Points near infinity, in [0, 1]: depth log-uniform up to far_factor.
  double far_factor =
      1e6;  ///< Largest depth in baselines (distance of neighbouring cameras), in [100, 1e9].

  double pixel_noise = 0.5;       ///< σ of each image coordinate in px, >= 0.
  double outlier_fraction = 0.0;  ///< Observations replaced by a uniform pixel, in [0, 0.999].

  double rotation_noise_deg =
      0.5;  ///< Start: σ of each rotation-vector component in degrees, >= 0.
  double translation_noise =
      0.01;  ///< Start: σ of each centre coordinate / typical viewing distance, >= 0.
  double point_noise = 0.01;  ///< Start: σ of each point coordinate / distance of its camera, >= 0.
  double focal_noise = 0.01;  ///< Start: relative σ of the focal lengths, in [0, 0.3].
  double distortion_noise = 0.1;  ///< Start: relative σ of k1 and k2, >= 0.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// Random camera parameters keep within this many σ of their mean.
inline constexpr double kMaxCameraSigmas = 2.5;

/// Square of the largest normalised radius ‖P_xy / P_z‖ that the generator projects: the image
/// corner at the shortest focal length, with a margin for distortion.
double max_squared_radius(const SyntheticBalOptions& options);

}  // namespace raylign
