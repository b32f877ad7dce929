// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/prepared_images.h"

#include <algorithm>
#include <cmath>

#include "raylign/photometric/pixel_noise.h"

namespace raylign::photometric {
namespace {

// Along the rows, written as columns: twice is a blur in both directions.
Plane<float> smoothed_and_transposed(const Plane<float>& image, const std::vector<double>& kernel) {
  const int radius = static_cast<int>(kernel.size() / 2);
  Plane<float> out(image.height(), image.width());
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      double sum = 0.0;
      for (int i = -radius; i <= radius; ++i) {
        sum += kernel[i + radius] * image.at(std::clamp(u + i, 0, image.width() - 1), v);
      }
      out.at(v, u) = static_cast<float>(sum);
    }
  }
  return out;
}

ImagePyramid smoothed_pyramid(const ImagePyramid& pyramid, double sigma) {
  const Plane<float> image = smoothed(pyramid.level(0), sigma);
  PyramidOptions options;
  options.max_levels = pyramid.num_levels();
  options.min_side = 1;
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(image.width());
  return ImagePyramid(
      {image.data(), PixelType::FLOAT32, image.width(), image.height(), 1, row_bytes}, options);
}

// Smoothing trades noise for a bias: equal blur in images that see a wall at unequal sizes. The
// bias grows with the square of the width, what noise does with σ; so the width goes with √σ. On
// rendered rooms the bias is then a tenth of the error.
double presmooth_of(const PhotometricProblem& problem, const PhotometricOptions& options) {
  constexpr double kWidth = 0.3;  // px at a noise of one grey level; below that nothing is gained
  constexpr double kMaxWidth = 0.7;
  if (options.presmooth >= 0.0) return options.presmooth;
  if (problem.has_patches() || problem.images.empty()) return 0.0;
  std::vector<double> noise;
  for (const auto& image : problem.images) noise.push_back(estimate_pixel_noise(image->level(0)));
  const auto middle = noise.begin() + static_cast<std::ptrdiff_t>(noise.size() / 2);
  std::nth_element(noise.begin(), middle, noise.end());
  const double width = kWidth * std::sqrt(*middle);
  return width < kWidth ? 0.0 : std::min(width, kMaxWidth);
}

Plane<std::uint8_t> halved(const Plane<std::uint8_t>& fine) {
  Plane<std::uint8_t> coarse(fine.width() / 2, fine.height() / 2);
  for (int v = 0; v < coarse.height(); ++v) {
    const std::uint8_t* upper = fine.row(2 * v);
    const std::uint8_t* lower = fine.row(2 * v + 1);
    for (int u = 0; u < coarse.width(); ++u) {
      const int count = upper[2 * u] + upper[2 * u + 1] + lower[2 * u] + lower[2 * u + 1];
      coarse.at(u, v) = count >= 2 ? 1 : 0;
    }
  }
  return coarse;
}

}  // namespace

PixelMask::PixelMask(const ImagePyramid& pyramid,
                     const Plane<std::uint8_t>* given,
                     double min_grey,
                     double max_grey) {
  const Plane<float>& image = pyramid.level(0);
  Plane<std::uint8_t> mask(image.width(), image.height());
  bool all = true;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const float grey = image.data()[i];
    const bool counts =
        grey >= min_grey && grey <= max_grey && (given == nullptr || given->data()[i] != 0);
    mask.data()[i] = counts ? 1 : 0;
    all = all && counts;
  }
  if (all) return;
  levels_.push_back(std::move(mask));
  while (static_cast<int>(levels_.size()) < pyramid.num_levels()) {
    levels_.push_back(halved(levels_.back()));
  }
}

bool PixelMask::counts(int level, double u, double v) const {
  if (levels_.empty()) return true;
  const Plane<std::uint8_t>& mask = levels_[static_cast<std::size_t>(level)];
  const int u0 = std::clamp(static_cast<int>(u), 0, mask.width() - 1);
  const int v0 = std::clamp(static_cast<int>(v), 0, mask.height() - 1);
  const int u1 = std::min(u0 + (u > u0 ? 1 : 0), mask.width() - 1);
  const int v1 = std::min(v0 + (v > v0 ? 1 : 0), mask.height() - 1);
  return (mask.at(u0, v0) & mask.at(u1, v0) & mask.at(u0, v1) & mask.at(u1, v1)) != 0;
}

PreparedImages prepare_images(const PhotometricProblem& problem,
                              const PhotometricOptions& options) {
  const double presmooth = presmooth_of(problem, options);
  PreparedImages prepared{{}, {}, presmooth, SampledNoise(options.interpolation, presmooth)};
  for (std::int64_t i = 0; i < problem.num_images(); ++i) {
    const ImagePyramid& given = *problem.images[i];
    const Plane<std::uint8_t>* mask = problem.masks.empty() ? nullptr : problem.masks[i].get();
    prepared.masks.emplace_back(given, mask, options.visibility.min_grey,
                                options.visibility.max_grey);
    prepared.images.push_back(
        std::make_shared<PatchImage>(presmooth > 0.0 ? smoothed_pyramid(given, presmooth) : given,
                                     options.interpolation, options.border));
    const int levels = given.num_levels();
    prepared.num_levels = i == 0 ? levels : std::min(prepared.num_levels, levels);
  }
  return prepared;
}

Plane<float> smoothed(const Plane<float>& image, double sigma) {
  const std::vector<double> kernel = gaussian_kernel(sigma);
  return smoothed_and_transposed(smoothed_and_transposed(image, kernel), kernel);
}

}  // namespace raylign::photometric
