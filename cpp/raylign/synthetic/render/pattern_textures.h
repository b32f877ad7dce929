// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/synthetic/render/texture.h"

namespace raylign::render {

/// Squares of side min_wavelength / 2, mean ± contrast, first square at the origin bright. Banded:
/// the exact mean over the box that the pixel's footprint spans along the axes of texture space.
class CheckerTexture : public Texture {
 public:
  CheckerTexture(const TextureOptions& options, TextureSpace space);

  void evaluate(const WavePoints& points, double* value) const override;
  void evaluate_banded(const WavePoints& points, double* value) const override;
  /// The gradient is zero, as it is everywhere but on the edges.
  void evaluate_with_gradient(const WavePoints& points,
                              double* value,
                              double* const gradient[3]) const override;

 private:
  double side_, mean_, contrast_;
  int num_axes_;
};

/// Octaves of value noise: random numbers on a cubic lattice, blended with 6t⁵ − 15t⁴ + 10t³
/// (Perlin, SIGGRAPH 2002), cells from max_wavelength / 2 down to min_wavelength / 2, amplitude
/// ~ √cell. Banded: an octave fades out as its period falls from 4 px to 2.5 px.
class NoiseTexture : public Texture {
 public:
  NoiseTexture(const TextureOptions& options, std::uint64_t stream);

  void evaluate(const WavePoints& points, double* value) const override;
  void evaluate_banded(const WavePoints& points, double* value) const override;
  void evaluate_with_gradient(const WavePoints& points,
                              double* value,
                              double* const gradient[3]) const override;

 private:
  struct Octave {
    double cells_per_unit;
    double amplitude;
    std::uint64_t salt;
    Vector3 offset;  // cells; keeps lattice planes off the surface
  };

  std::vector<Octave> octaves_;
  double mean_;
};

}  // namespace raylign::render
