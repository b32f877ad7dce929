// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "raylign/image/plane.h"
#include "raylign/image/pyramid.h"
#include "raylign/patch/patch_image.h"
#include "raylign/photometric/options.h"
#include "raylign/photometric/problem.h"
#include "raylign/photometric/sampled_noise.h"

namespace raylign::photometric {

/// Which pixels of an image count, level by level: a pixel of a level does when half of the four
/// below do. Their mean is little off then, and coarse levels keep enough pixels to bring the fine
/// ones near.
class PixelMask {
 public:
  PixelMask() = default;  ///< every pixel counts
  /// @param given  0: does not count; or null
  PixelMask(const ImagePyramid& pyramid,
            const Plane<std::uint8_t>* given,
            double min_grey,
            double max_grey);

  /// Whether the pixels around a position inside the level all count.
  bool counts(int level, double u, double v) const;

 private:
  std::vector<Plane<std::uint8_t>> levels_;
};

/// The images of a problem, ready to be read.
struct PreparedImages {
  std::vector<std::shared_ptr<const PatchImage>> images;  ///< (M,)
  std::vector<PixelMask> masks;                           ///< (M,)
  double presmooth = 0.0;                                 ///< σ of the Gaussian on them, px
  SampledNoise noise;                                     ///< of what is read from them
  int num_levels = 1;                                     ///< that all images have
};

PreparedImages prepare_images(const PhotometricProblem& problem, const PhotometricOptions& options);

/// Gaussian blur, σ in px, border pixels repeated.
Plane<float> smoothed(const Plane<float>& image, double sigma);

}  // namespace raylign::photometric
