// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/pyramid.h"

#include <algorithm>

#include "raylign/image/kernels.h"

namespace raylign {

void PyramidOptions::validate() const {
  require_option(max_levels >= 1, "PyramidOptions.max_levels", ">= 1", max_levels);
  require_option(min_side >= 1, "PyramidOptions.min_side", ">= 1", min_side);
}

int num_pyramid_levels(int width, int height, const PyramidOptions& options) {
  int levels = 1;
  int side = std::min(width, height) / 2;
  for (; levels < options.max_levels && side >= options.min_side; side /= 2) ++levels;
  return levels;
}

void ImagePyramid::assign(const ImageView& image, const PyramidOptions& options, ColorOrder order) {
  options.validate();
  image.validate();
  levels_.resize(num_pyramid_levels(image.width, image.height, options));
  to_grey(image, order, levels_.front());
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    const Plane<float>& fine = levels_[l - 1];
    Plane<float>& coarse = levels_[l];
    coarse.resize(fine.width() / 2, fine.height() / 2);
    for (int v = 0; v < coarse.height(); ++v) {
      image_kernels::halve(fine.row(2 * v), fine.row(2 * v + 1), coarse.width(), coarse.row(v));
    }
  }
}

}  // namespace raylign
