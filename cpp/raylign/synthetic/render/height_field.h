// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "raylign/synthetic/render/surface.h"

namespace raylign {

/// Smooth hills: z = Σ of plane waves over a rectangle of the plane z = 0.
struct HeightFieldOptions {
  double width = 6.0;           ///< Extent along x, scene units, finite and > 0.
  double height = 4.0;          ///< Extent along y, scene units, finite and > 0.
  double amplitude = 0.15;      ///< Standard deviation of z, scene units, finite and >= 0.
  double min_wavelength = 0.8;  ///< Shortest wavelength of the hills, scene units, > 0.
  double max_wavelength = 2.5;  ///< Longest wavelength, scene units, >= min_wavelength.
  int num_waves = 8;            ///< Plane waves, in [1, 256].
  std::uint64_t seed = 0;       ///< Draws the hills.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

}  // namespace raylign

namespace raylign::render {

/// Texture coordinates are (x, y). Options must be valid.
std::shared_ptr<const Surface> make_height_field(const HeightFieldOptions& options);

}  // namespace raylign::render
