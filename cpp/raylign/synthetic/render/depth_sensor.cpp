// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/depth_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/base/portable_math.h"
#include "raylign/base/random.h"
#include "raylign/depth/inverse_depth.h"

namespace raylign {
namespace {

using DoubleMap = Rows<double, Eigen::Dynamic>;
using FloatMap = Rows<float, Eigen::Dynamic>;

constexpr double kMaxLength = 64.0;
constexpr int kMaxSide = 32766;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

void require_length(const char* name, double length) {
  require_option(length >= 0.0 && length <= kMaxLength, name, "in [0, 64]", length);
}

// White noise through a Gaussian of σ = length / √2 has the wanted autocorrelation; Σ weight² = 1
// keeps the variance.
std::vector<double> correlation_kernel(double length) {
  if (length == 0.0) return {1.0};
  const int radius = static_cast<int>(std::ceil(3.0 * length));
  std::vector<double> kernel;
  double sum = 0.0;
  for (int k = -radius; k <= radius; ++k) {
    kernel.push_back(portable::exp(-(1.0 * k * k) / (length * length)));
    sum += kernel.back() * kernel.back();
  }
  for (double& weight : kernel) weight /= std::sqrt(sum);
  return kernel;
}

// The sensor's own rule for range and steps, and σ of the noise: D = 0 where there is no depth.
void apply_model(const Eigen::Ref<const DoubleMap>& depth,
                 const DepthModel& model,
                 FloatMap& D,
                 FloatMap& V) {
  const FloatMap measured = depth.cast<float>();
  ImageView view;
  view.data = measured.data();
  view.type = PixelType::FLOAT32;
  view.width = static_cast<int>(depth.cols());
  view.height = static_cast<int>(depth.rows());
  view.row_stride = view.row_bytes();
  D.resize(depth.rows(), depth.cols());
  V.resize(depth.rows(), depth.cols());
  InverseDepthConverter(model).convert(view, 1.0, D.data(), V.data());
}

bool is_grazing(
    const RadtanCamera& camera, const Vector3& normal, double u, double v, double min_cosine) {
  Vector3 bearing;
  return !camera.unproject(Vector2(u, v), bearing) ||
         !(std::abs(bearing.dot(normal)) >= min_cosine);
}

}  // namespace

void DepthSensorOptions::validate() const {
  model.validate();
  require_option(noise >= 0.0 && std::isfinite(noise), "DepthSensorOptions.noise",
                 "finite and >= 0", noise);
  require_length("DepthSensorOptions.correlation_length", correlation_length);
  require_option(inverse_depth_step >= 0.0 && std::isfinite(inverse_depth_step),
                 "DepthSensorOptions.inverse_depth_step", "finite and >= 0", inverse_depth_step);
  require_option(max_incidence_deg > 0.0 && max_incidence_deg <= 90.0,
                 "DepthSensorOptions.max_incidence_deg", "in (0, 90]", max_incidence_deg);
  require_option(dropout >= 0.0 && dropout <= 1.0, "DepthSensorOptions.dropout", "in [0, 1]",
                 dropout);
}

DoubleMap noise_field(
    int width, int height, double correlation_length, std::uint64_t seed, std::uint64_t index) {
  require_length("correlation_length", correlation_length);
  if (std::min(width, height) < 1 || std::max(width, height) > kMaxSide) {
    throw ShapeError("width and height must be in [1, 32766], got " + std::to_string(width) +
                     " x " + std::to_string(height));
  }
  const std::vector<double> kernel = correlation_kernel(correlation_length);
  const int num_taps = static_cast<int>(kernel.size());
  std::vector<double> white(width + num_taps - 1);
  DoubleMap field = DoubleMap::Zero(height, width);
  Eigen::RowVectorXd row(width);
  for (int j = 0; j < height + num_taps - 1; ++j) {
    RandomStream random(seed, "noise_field", index, j);
    for (double& value : white) value = random.normal();
    row.setZero();
    for (int k = 0; k < num_taps; ++k) {
      row += kernel[k] * Eigen::Map<const Eigen::RowVectorXd>(white.data() + k, width);
    }
    for (int k = std::max(0, j - height + 1); k < num_taps && k <= j; ++k) {
      field.row(j - k) += kernel[k] * row;
    }
  }
  return field;
}

FloatMap sense_depth(const Eigen::Ref<const DoubleMap>& depth,
                     const Eigen::Ref<const Rows<double, 3>>& normal,
                     const RadtanCamera& camera,
                     const DepthSensorOptions& options,
                     std::uint64_t seed,
                     std::uint64_t index) {
  options.validate();
  camera.validate();
  if (normal.rows() != depth.size())
    throw ShapeError("normal must hold one row per pixel of depth");
  const int width = static_cast<int>(depth.cols());
  const int height = static_cast<int>(depth.rows());
  FloatMap D, V;
  apply_model(depth, options.model, D, V);
  const DoubleMap noise = noise_field(width, height, options.correlation_length, seed, index);
  // cos 90° is not 0 in double: every incidence is allowed.
  const double min_cosine = options.max_incidence_deg == 90.0
                                ? 0.0
                                : portable::sincos(kDegree * options.max_incidence_deg).cos;
  FloatMap out = FloatMap::Constant(height, width, std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < height; ++v) {
    RandomStream random(seed, "depth_dropout", index, v);
    for (int u = 0; u < width; ++u) {
      const bool is_dropped = random.uniform() < options.dropout;
      const Vector3 n = normal.row(static_cast<Eigen::Index>(v) * width + u);
      if (is_dropped || D(v, u) == 0.0F || is_grazing(camera, n, u, v, min_cosine)) continue;
      double inverse = 1.0 / depth(v, u) + options.noise * std::sqrt(V(v, u)) * noise(v, u);
      const double step = options.inverse_depth_step;
      if (step > 0.0) inverse = step * std::floor(inverse / step + 0.5);
      if (inverse > 0.0) out(v, u) = static_cast<float>(1.0 / inverse);
    }
  }
  return out;
}

}  // namespace raylign
