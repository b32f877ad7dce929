// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "raylign/depth/depth_noise_law.h"

namespace raylign {

/// How the error of a measured depth Z grows with Z.
enum class DepthNoise {
  KINECT,          ///< structured light: σ_Z = sigma (0.0012 + 0.0019 (Z − 0.4)²) m. Nguyen 2012.
  DISPARITY,       ///< stereo: disparity with σ = sigma px, so σ_D = sigma / (f b)
  TIME_OF_FLIGHT,  ///< σ_Z = sigma m at every distance
  CONSTANT,        ///< σ_D = sigma 1/m at every distance
};

/// What a depth sensor's numbers are worth: the law of their noise, the range in which they are
/// believed, and how near to a step of the depth they are not. Value type.
struct DepthModel {
  DepthNoise noise = DepthNoise::KINECT;
  /// > 0, or 0 for the law's own: 1 (KINECT, a factor), 0.5 px (DISPARITY), 0.01 m
  /// (TIME_OF_FLIGHT), 0.002 1/m (CONSTANT).
  double sigma = 0.0;
  double focal_baseline = 0.0;  ///< f · b in px · m; > 0 with DISPARITY, unused by the others.
  double min_depth = 0.1;       ///< m, > 0; nearer is invalid.
  double max_depth = 20.0;      ///< m, > min_depth; farther is invalid.
  /// A pixel is invalid when the inverse depths within edge_radius differ by more than edge_ratio
  /// of its own: near a step a sensor reports either side, or neither. >= 0; 0 keeps all.
  double edge_ratio = 0.1;
  int edge_radius = 1;  ///< px, in [0, 16]; 0 keeps all.

  /// The law of σ_D with Z = 1/D put in.
  DepthNoiseLaw<double> law() const;
  /// Standard deviation of the inverse depth 1/Z, in 1/m, to first order: σ_Z / Z².
  double inverse_depth_sigma(double depth) const;
  /// `sigma`, or the law's own where it is 0.
  double effective_sigma() const;
  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// "kinect", …: the lower-case enumerator.
std::string to_string(DepthNoise noise);

}  // namespace raylign
