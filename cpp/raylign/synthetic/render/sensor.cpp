// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raylign/base/error.h"
#include "raylign/base/portable_math.h"
#include "raylign/base/random.h"

namespace raylign {
namespace {

constexpr double kWhite = 255.0;

void require_finite(const char* field, double value) {
  require_option(std::isfinite(value), field, "finite", value);
}

void require_not_negative(const char* field, double value) {
  require_option(value >= 0.0 && std::isfinite(value), field, "finite and >= 0", value);
}

double vignette(const SensorOptions& o, double r2) {
  return 1.0 + r2 * (o.vignette_r2 + r2 * (o.vignette_r4 + r2 * o.vignette_r6));
}

void validate_lut(const SensorOptions& o) {
  if (o.response != SensorResponse::LUT) return;
  const bool is_valid =
      o.lut.size() >= 2 && std::is_sorted(o.lut.begin(), o.lut.end()) &&
      std::all_of(o.lut.begin(), o.lut.end(), [](double y) { return y >= 0.0 && y <= kWhite; });
  if (!is_valid) {
    throw OptionsError(
        "SensorOptions.lut must hold at least two values in [0, 255] that do not decrease");
  }
}

double respond(const SensorOptions& o, double x) {
  switch (o.response) {
    case SensorResponse::GAMMA: {
      constexpr double kBlack = 1e-12;  // below, the logarithm has nothing to say
      if (x <= kBlack) return 0.0;
      return kWhite * portable::exp(portable::log(x / kWhite) / o.gamma);
    }
    case SensorResponse::LUT: {
      const double last = static_cast<double>(o.lut.size() - 1);
      const double position = std::clamp(x / kWhite, 0.0, 1.0) * last;
      const std::size_t i = static_cast<std::size_t>(std::min(position, last - 1.0));
      const double weight = position - static_cast<double>(i);
      return (1.0 - weight) * o.lut[i] + weight * o.lut[i + 1];
    }
    case SensorResponse::LINEAR:
      break;
  }
  return x;
}

template <typename T>
void store(Image& image, int v, const std::vector<double>& row, double scale) {
  constexpr double kMax = static_cast<double>(std::numeric_limits<T>::max());
  T* out = static_cast<T*>(image.data()) + static_cast<std::size_t>(v) * row.size();
  for (std::size_t u = 0; u < row.size(); ++u) {
    out[u] = static_cast<T>(std::clamp(std::floor(scale * row[u] + 0.5), 0.0, kMax));
  }
}

void store_row(Image& image, int v, const std::vector<double>& row) {
  switch (image.type()) {
    case PixelType::UINT8:
      return store<std::uint8_t>(image, v, row, 1.0);
    case PixelType::UINT16:
      return store<std::uint16_t>(image, v, row, 65535.0 / kWhite);
    case PixelType::FLOAT32:
      break;
  }
  float* out = static_cast<float*>(image.data()) + static_cast<std::size_t>(v) * row.size();
  std::transform(row.begin(), row.end(), out, [](double x) { return static_cast<float>(x); });
}

}  // namespace

void SensorOptions::validate() const {
  require_option(exposure > 0.0 && std::isfinite(exposure), "SensorOptions.exposure",
                 "finite and > 0", exposure);
  require_option(gain >= -10.0 && gain <= 10.0, "SensorOptions.gain", "in [-10, 10]", gain);
  require_finite("SensorOptions.bias", bias);
  require_finite("SensorOptions.vignette_r2", vignette_r2);
  require_finite("SensorOptions.vignette_r4", vignette_r4);
  require_finite("SensorOptions.vignette_r6", vignette_r6);
  constexpr int kSteps = 64;
  for (int i = 0; i <= kSteps; ++i) {
    const double value = vignette(*this, static_cast<double>(i) / kSteps);
    require_option(value > 0.0, "SensorOptions.vignette_r2, r4, r6: the vignette",
                   "> 0 in the whole image", value);
  }
  require_option(gamma >= 0.1 && gamma <= 10.0, "SensorOptions.gamma", "in [0.1, 10]", gamma);
  validate_lut(*this);
  require_not_negative("SensorOptions.read_noise", read_noise);
  require_not_negative("SensorOptions.shot_noise", shot_noise);
}

Image expose(const Eigen::Ref<const Rows<double, Eigen::Dynamic>>& irradiance,
             const SensorOptions& options,
             std::uint64_t seed,
             std::uint64_t index) {
  options.validate();
  const int width = static_cast<int>(irradiance.cols());
  const int height = static_cast<int>(irradiance.rows());
  if (width < 1 || height < 1) throw ShapeError("irradiance must have pixels");
  Image image(options.format, width, height, 1);
  const double factor = options.exposure * portable::exp(options.gain);
  const double half_diagonal_squared = 0.25 * (1.0 * width * width + 1.0 * height * height);
  const double read_variance = options.read_noise * options.read_noise;
  const bool is_noisy = options.read_noise > 0.0 || options.shot_noise > 0.0;
  std::vector<double> row(width);
  for (int v = 0; v < height; ++v) {
    RandomStream random(seed, "sensor_noise", index, v);
    const double dv = v - 0.5 * (height - 1);
    for (int u = 0; u < width; ++u) {
      const double du = u - 0.5 * (width - 1);
      const double light = vignette(options, (du * du + dv * dv) / half_diagonal_squared) * factor *
                           irradiance(v, u);
      row[u] = respond(options, light + options.bias);
      if (!is_noisy) continue;
      const double variance = read_variance + options.shot_noise * std::max(0.0, row[u]);
      row[u] += std::sqrt(variance) * random.normal();
    }
    store_row(image, v, row);
  }
  return image;
}

}  // namespace raylign
