// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/image/image.h"

namespace raylign {

/// Grey value out for light in, both on the scale 0..255.
enum class SensorResponse {
  LINEAR,  ///< x
  GAMMA,   ///< 255 (x / 255)^(1 / gamma)
  LUT,     ///< linear between `lut`'s values at equal steps from 0 to 255; ends held
};

/// A camera's sensor and electronics:
///   I = response(vignette(r) · exposure · e^gain · irradiance + bias) + N(0, read² + shot · I),
/// then rounded and clipped to the pixel format. r is the distance to the image centre over half
/// the diagonal: 1 at the corners' outer edge.
struct SensorOptions {
  double exposure = 1.0;     ///< Factor of the light, finite and > 0.
  double gain = 0.0;         ///< a: the light is multiplied by e^a, in [-10, 10].
  double bias = 0.0;         ///< b: grey values added, finite.
  double vignette_r2 = 0.0;  ///< vignette(r) = 1 + vignette_r2 r² + vignette_r4 r⁴ + vignette_r6 r⁶
  double vignette_r4 = 0.0;  ///< finite
  double vignette_r6 = 0.0;  ///< finite; the polynomial must be positive on [0, 1]
  SensorResponse response = SensorResponse::LINEAR;
  double gamma = 2.2;       ///< GAMMA: in [0.1, 10].
  std::vector<double> lut;  ///< LUT: at least two values, not decreasing, in [0, 255].
  double read_noise = 0.0;  ///< Sigma of the signal-independent noise in grey values, >= 0.
  double shot_noise = 0.0;  ///< Variance of the noise per grey value, >= 0.
  PixelType format = PixelType::UINT8;  ///< UINT16: 65535 is grey 255; FLOAT32: as it is.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// What the sensor makes of an irradiance map (height, width). The noise of frame `index` follows
/// from (seed, index) and the pixel: frames may be made in any order. Throws OptionsError for bad
/// options, ShapeError for a map without pixels. Cost: about 50 ns per pixel with noise.
Image expose(const Eigen::Ref<const Rows<double, Eigen::Dynamic>>& irradiance,
             const SensorOptions& options,
             std::uint64_t seed = 0,
             std::uint64_t index = 0);

}  // namespace raylign
