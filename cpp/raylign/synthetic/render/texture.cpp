// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/texture.h"

#include <algorithm>
#include <cmath>

#include "raylign/base/error.h"
#include "raylign/base/portable_math.h"
#include "raylign/base/random.h"
#include "raylign/synthetic/render/pattern_textures.h"

namespace raylign {

void TextureOptions::validate() const {
  require_option(min_wavelength > 0.0 && std::isfinite(min_wavelength),
                 "TextureOptions.min_wavelength", "finite and > 0", min_wavelength);
  require_option(max_wavelength >= min_wavelength && std::isfinite(max_wavelength),
                 "TextureOptions.max_wavelength", "finite and >= min_wavelength", max_wavelength);
  require_option(num_waves >= 1 && num_waves <= 4096, "TextureOptions.num_waves", "in [1, 4096]",
                 num_waves);
  require_option(mean >= 0.0 && mean <= 255.0, "TextureOptions.mean", "in [0, 255]", mean);
  require_option(contrast >= 0.0 && std::isfinite(contrast), "TextureOptions.contrast",
                 "finite and >= 0", contrast);
}

}  // namespace raylign

namespace raylign::render {
namespace {

constexpr double kTwoPi = 6.283185307179586;

// Uniform on the unit circle, or on the unit sphere (Archimedes: z is uniform).
Vector3 random_direction(RandomStream& random, TextureSpace space) {
  const auto [s, c] = portable::sincos(random.uniform(0.0, kTwoPi));
  if (space == TextureSpace::PLANE) return {c, s, 0.0};
  const double z = random.uniform(-1.0, 1.0);
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * c, radius * s, z};
}

class WaveTexture : public Texture {
 public:
  WaveTexture(WaveTable waves, double mean) : waves_(std::move(waves)), mean_(mean) {}

  void evaluate(const WavePoints& points, double* value) const override {
    sum_waves(waves_.view(), points, value);
    add_mean(points.size, value);
  }
  void evaluate_banded(const WavePoints& points, double* value) const override {
    if (is_resolved(points)) {
      sum_waves(waves_.view(), points, value);
    } else {
      sum_banded_waves(waves_.view(), points, value);
    }
    add_mean(points.size, value);
  }
  void evaluate_with_gradient(const WavePoints& points,
                              double* value,
                              double* const gradient[3]) const override {
    sum_wave_gradients(waves_.view(), points, value, gradient);
    add_mean(points.size, value);
  }

 private:
  void add_mean(int size, double* value) const {
    for (int i = 0; i < size; ++i) value[i] += mean_;
  }

  // True when every wave passes whole at every point (|Jᵀf|² <= ‖J‖² |f|²): the cheap sum is then
  // the same, bit by bit, because a weight of one changes nothing.
  bool is_resolved(const WavePoints& points) const {
    const Waves waves = waves_.view();
    double highest = 0.0;
    for (int k = 0; k < waves.count; ++k) {
      double square = 0.0;
      for (const double* f : waves.frequency) square += f[k] * f[k];
      highest = std::max(highest, square);
    }
    const double limit = 4.0 / (kPassWavelength * kPassWavelength * highest);
    bool resolved = true;
    for (int i = 0; i < points.size; ++i) {
      double square = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        square += points.by_u[axis][i] * points.by_u[axis][i] +
                  points.by_v[axis][i] * points.by_v[axis][i];
      }
      resolved &= square <= limit;
    }
    return resolved;
  }

  WaveTable waves_;
  double mean_;
};

}  // namespace

void WaveTable::add(const Vector3& frequency, double phase, double amplitude) {
  for (int axis = 0; axis < 3; ++axis) frequency_[axis].push_back(frequency[axis]);
  phase_.push_back(phase);
  amplitude_.push_back(amplitude);
}

Waves WaveTable::view() const {
  Waves waves;
  waves.count = size();
  for (int axis = 0; axis < 3; ++axis) waves.frequency[axis] = frequency_[axis].data();
  waves.phase = phase_.data();
  waves.amplitude = amplitude_.data();
  return waves;
}

WaveTable random_waves(std::uint64_t seed,
                       std::uint64_t stream,
                       TextureSpace space,
                       int count,
                       double low,
                       double high,
                       double sigma) {
  RandomStream random(seed, "texture_waves", stream);
  const double octaves = portable::log(high / low);
  std::vector<double> wavelengths;
  double sum = 0.0;
  for (int k = 0; k < count; ++k) {
    wavelengths.push_back(low * portable::exp(octaves * random.uniform()));
    sum += wavelengths.back();
  }
  const double scale = sigma * std::sqrt(2.0 / sum);
  WaveTable waves;
  for (const double wavelength : wavelengths) {
    const Vector3 direction = random_direction(random, space);
    waves.add(2.0 / wavelength * direction, random.uniform(0.0, 2.0),
              scale * std::sqrt(wavelength));
  }
  return waves;
}

std::shared_ptr<const Texture> make_texture(const TextureOptions& options,
                                            TextureSpace space,
                                            std::uint64_t stream) {
  switch (options.kind) {
    case TextureKind::NOISE:
      return std::make_shared<NoiseTexture>(options, stream);
    case TextureKind::CHECKER:
      return std::make_shared<CheckerTexture>(options, space);
    case TextureKind::UNIFORM:
      return std::make_shared<WaveTexture>(WaveTable(), options.mean);
    case TextureKind::BANDLIMITED:
      break;
  }
  return std::make_shared<WaveTexture>(
      random_waves(options.seed, stream, space, options.num_waves, options.min_wavelength,
                   options.max_wavelength, options.contrast),
      options.mean);
}

}  // namespace raylign::render
