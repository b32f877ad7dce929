// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/image/image.h"
#include "raylign/image/image_view.h"

namespace raylign {

enum class Interpolation {
  NEAREST,
  LINEAR,  ///< OpenCV rounds coordinates to 1/32 px
  CUBIC,   ///< as LINEAR; may overshoot
};

/// Map of float32 coordinates, (height, width) of the result, px of the source.
using CoordinateMap = Eigen::Ref<const Rows<float, Eigen::Dynamic>>;

/// result(v, u) = image(map_y(v, u), map_x(v, u)); 0 outside the image and where a map is not
/// finite. Pixel type and channels are kept. Implemented by OpenCV's cv::remap. Throws ShapeError
/// when the maps disagree, the image is empty or a side exceeds 32766 px.
Image remap(const ImageView& image,
            const CoordinateMap& map_x,
            const CoordinateMap& map_y,
            Interpolation interpolation = Interpolation::LINEAR);

}  // namespace raylign
