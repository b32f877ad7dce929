// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/pattern_textures.h"

#include <algorithm>
#include <cmath>

#include "raylign/base/random.h"

namespace raylign::render {
namespace {

Vector3 point_at(const WavePoints& points, int i) {
  return {points.position[0][i], points.position[1][i], points.position[2][i]};
}

// ∫₀ˣ of the square wave that is +1 on [0, 1), −1 on [1, 2): a triangle wave.
double triangle(double x) {
  const double phase = x - 2.0 * std::floor(0.5 * x);
  return phase < 1.0 ? phase : 2.0 - phase;
}

double square(double x) { return x - 2.0 * std::floor(0.5 * x) < 1.0 ? 1.0 : -1.0; }

// Mean of the square wave over [x − width/2, x + width/2].
double box_mean(double x, double width) {
  constexpr double kPoint = 1e-9;  // below, the difference quotient has no digits left
  if (width < kPoint) return square(x);
  return (triangle(x + 0.5 * width) - triangle(x - 0.5 * width)) / width;
}

// Uniform with variance 1, by lattice point.
double lattice_value(std::uint64_t salt, std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr double kHalfRange = 1.7320508075688772;  // √3
  std::uint64_t state = salt;
  for (const std::int64_t part : {x, y, z}) {
    state = splitmix64(state) ^ static_cast<std::uint64_t>(part);
  }
  return kHalfRange * (static_cast<double>(splitmix64(state) >> 11) * 0x1.0p-52 - 1.0);
}

struct Blend {
  double weight, slope;
};

Blend quintic(double t) {
  return {t * t * t * ((6.0 * t - 15.0) * t + 10.0), 30.0 * t * t * (t - 1.0) * (t - 1.0)};
}

// Value noise at p (in cells) and its gradient.
double value_noise(std::uint64_t salt, const Vector3& p, Vector3* gradient) {
  const Vector3 base = p.array().floor();
  const Blend bx = quintic(p.x() - base.x());
  const Blend by = quintic(p.y() - base.y());
  const Blend bz = quintic(p.z() - base.z());
  double value = 0.0;
  if (gradient) gradient->setZero();
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const double v = lattice_value(salt, static_cast<std::int64_t>(base.x()) + i,
                                   static_cast<std::int64_t>(base.y()) + j,
                                   static_cast<std::int64_t>(base.z()) + k);
    const double wx = i ? bx.weight : 1.0 - bx.weight;
    const double wy = j ? by.weight : 1.0 - by.weight;
    const double wz = k ? bz.weight : 1.0 - bz.weight;
    value += v * wx * wy * wz;
    if (!gradient) continue;
    *gradient +=
        v * Vector3((i ? bx.slope : -bx.slope) * wy * wz, (j ? by.slope : -by.slope) * wx * wz,
                    (k ? bz.slope : -bz.slope) * wx * wy);
  }
  return value;
}

// Largest extent of the footprint along any direction: ‖[by_u by_v]‖_F.
double footprint(const WavePoints& points, int i) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    sum +=
        points.by_u[axis][i] * points.by_u[axis][i] + points.by_v[axis][i] * points.by_v[axis][i];
  }
  return std::sqrt(sum);
}

double fade(double wavelength_px) {
  const double s = (wavelength_px - kStopWavelength) / (kPassWavelength - kStopWavelength);
  return quintic(std::clamp(s, 0.0, 1.0)).weight;
}

}  // namespace

CheckerTexture::CheckerTexture(const TextureOptions& options, TextureSpace space)
    : side_(0.5 * options.min_wavelength),
      mean_(options.mean),
      contrast_(options.contrast),
      num_axes_(space == TextureSpace::SOLID ? 3 : 2) {}

void CheckerTexture::evaluate(const WavePoints& points, double* value) const {
  for (int i = 0; i < points.size; ++i) {
    double sign = 1.0;
    for (int axis = 0; axis < num_axes_; ++axis) sign *= square(points.position[axis][i] / side_);
    value[i] = mean_ + contrast_ * sign;
  }
}

void CheckerTexture::evaluate_banded(const WavePoints& points, double* value) const {
  for (int i = 0; i < points.size; ++i) {
    double product = 1.0;
    for (int axis = 0; axis < num_axes_; ++axis) {
      const double width = std::abs(points.by_u[axis][i]) + std::abs(points.by_v[axis][i]);
      product *= box_mean(points.position[axis][i] / side_, width / side_);
    }
    value[i] = mean_ + contrast_ * product;
  }
}

void CheckerTexture::evaluate_with_gradient(const WavePoints& points,
                                            double* value,
                                            double* const gradient[3]) const {
  evaluate(points, value);
  for (int axis = 0; axis < 3; ++axis) std::fill_n(gradient[axis], points.size, 0.0);
}

NoiseTexture::NoiseTexture(const TextureOptions& options, std::uint64_t stream)
    : mean_(options.mean) {
  // Variance of one octave at unit amplitude: Π Σ w² averaged over the cell, ∫ w² + (1 − w)² per
  // axis with the quintic w; 181/231 by integration.
  constexpr double kOctaveVariance = (181.0 / 231.0) * (181.0 / 231.0) * (181.0 / 231.0);
  RandomStream random(options.seed, "texture_noise", stream);
  double sum = 0.0;
  for (double wavelength = options.max_wavelength; wavelength >= options.min_wavelength;
       wavelength *= 0.5) {
    const double cell = 0.5 * wavelength;
    octaves_.push_back({1.0 / cell, std::sqrt(cell), random.bits(),
                        Vector3(random.uniform(), random.uniform(), random.uniform())});
    sum += cell * kOctaveVariance;
  }
  for (Octave& octave : octaves_) octave.amplitude *= options.contrast / std::sqrt(sum);
}

void NoiseTexture::evaluate(const WavePoints& points, double* value) const {
  for (int i = 0; i < points.size; ++i) {
    value[i] = mean_;
    for (const Octave& o : octaves_) {
      const Vector3 p = o.cells_per_unit * point_at(points, i) + o.offset;
      value[i] += o.amplitude * value_noise(o.salt, p, nullptr);
    }
  }
}

void NoiseTexture::evaluate_banded(const WavePoints& points, double* value) const {
  for (int i = 0; i < points.size; ++i) {
    value[i] = mean_;
    const double width = footprint(points, i);
    for (const Octave& o : octaves_) {
      const double weight = fade(2.0 / (o.cells_per_unit * width));
      if (weight == 0.0) continue;
      const Vector3 p = o.cells_per_unit * point_at(points, i) + o.offset;
      value[i] += weight * o.amplitude * value_noise(o.salt, p, nullptr);
    }
  }
}

void NoiseTexture::evaluate_with_gradient(const WavePoints& points,
                                          double* value,
                                          double* const gradient[3]) const {
  for (int i = 0; i < points.size; ++i) {
    value[i] = mean_;
    Vector3 sum = Vector3::Zero();
    for (const Octave& o : octaves_) {
      const Vector3 p = o.cells_per_unit * point_at(points, i) + o.offset;
      Vector3 slope;
      value[i] += o.amplitude * value_noise(o.salt, p, &slope);
      sum += o.amplitude * o.cells_per_unit * slope;
    }
    for (int axis = 0; axis < 3; ++axis) gradient[axis][i] = sum[axis];
  }
}

}  // namespace raylign::render
