// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace raylign {

/// What is painted on a surface.
enum class TextureKind {
  BANDLIMITED,  ///< a sum of plane waves: no detail below min_wavelength, derivatives of any order
  NOISE,        ///< octaves of C2 value noise: natural looking, detail at every scale in the range
  CHECKER,      ///< squares of side min_wavelength / 2
  UNIFORM,      ///< the mean alone
};

/// Options of a procedural texture: a function of the point on the surface, in grey values 0..255.
struct TextureOptions {
  TextureKind kind = TextureKind::BANDLIMITED;
  std::uint64_t seed = 0;        ///< Every face of every surface draws its own texture from it.
  double min_wavelength = 0.06;  ///< Shortest wavelength, scene units, > 0.
  double max_wavelength = 0.6;   ///< Longest wavelength, scene units, >= min_wavelength.
  int num_waves = 60;            ///< BANDLIMITED: plane waves, in [1, 4096].
  double mean = 128.0;           ///< Mean grey value, in [0, 255].
  double contrast = 32.0;        ///< Standard deviation in grey values, >= 0; CHECKER: exactly.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

}  // namespace raylign
