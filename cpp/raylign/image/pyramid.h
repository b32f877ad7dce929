// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/image/grey.h"
#include "raylign/image/image_view.h"
#include "raylign/image/plane.h"

namespace raylign {

struct PyramidOptions {
  int max_levels = 5;  ///< >= 1, level 0 counts
  int min_side = 16;   ///< px, >= 1: no level below level 0 has a shorter side

  /// Throws OptionsError.
  void validate() const;
};

/// Levels that an image of this size gets: at least one, whatever its size.
int num_pyramid_levels(int width, int height, const PyramidOptions& options);

/// Grey float images, each half the size of the one before: a pixel of level l + 1 is the mean of
/// the 2x2 pixels (2u..2u+1, 2v..2v+1) of level l; the last column or row of an odd size is
/// dropped. The camera of level l is PinholeCamera::at_level(l), the rule that fits this filter.
class ImagePyramid {
 public:
  ImagePyramid() = default;
  explicit ImagePyramid(const ImageView& image,
                        const PyramidOptions& options = {},
                        ColorOrder order = ColorOrder::RGB) {
    assign(image, options, order);
  }

  /// Rebuilds from a new image; allocates nothing when it has had this size and number of levels
  /// before. Throws ShapeError for an empty or invalid view, OptionsError.
  void assign(const ImageView& image,
              const PyramidOptions& options = {},
              ColorOrder order = ColorOrder::RGB);

  int num_levels() const { return static_cast<int>(levels_.size()); }
  const Plane<float>& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }

 private:
  std::vector<Plane<float>> levels_;
};

}  // namespace raylign
