// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "raylign/base/eigen.h"
#include "raylign/synthetic/render/sinusoid_kernels.h"
#include "raylign/synthetic/render/texture_options.h"

namespace raylign::render {

/// A grey value at every point of texture space (on flat surfaces the plane z = 0). Immutable.
class Texture {
 public:
  virtual ~Texture() = default;

  /// Grey values at points.position.
  virtual void evaluate(const WavePoints& points, double* value) const = 0;
  /// The same without what the pixel footprint [by_u by_v] cannot resolve.
  virtual void evaluate_banded(const WavePoints& points, double* value) const = 0;
  /// Grey values and their gradient by position.
  virtual void evaluate_with_gradient(const WavePoints& points,
                                      double* value,
                                      double* const gradient[3]) const = 0;
};

/// How a texture fills space.
enum class TextureSpace {
  PLANE,  ///< varies along x and y only
  SOLID,  ///< varies along x, y and z: for curved surfaces
};

/// The texture of one face; `stream` tells the faces of a scene apart. Options must be valid.
std::shared_ptr<const Texture> make_texture(const TextureOptions& options,
                                            TextureSpace space,
                                            std::uint64_t stream);

/// Arrays behind Waves.
class WaveTable {
 public:
  void add(const Vector3& frequency, double phase, double amplitude);
  Waves view() const;
  int size() const { return static_cast<int>(phase_.size()); }

 private:
  std::vector<double> frequency_[3], phase_, amplitude_;
};

/// Plane waves in random directions, wavelengths log-uniform in [low, high], amplitude
/// ~ √wavelength (a 1/f-like spectrum), Σ amplitude² / 2 = sigma².
WaveTable random_waves(std::uint64_t seed,
                       std::uint64_t stream,
                       TextureSpace space,
                       int count,
                       double low,
                       double high,
                       double sigma);

}  // namespace raylign::render
