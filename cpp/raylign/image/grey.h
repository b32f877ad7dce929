// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/image/image_view.h"
#include "raylign/image/plane.h"

namespace raylign {

/// Which channel of a three-channel image comes first.
enum class ColorOrder {
  RGB,  ///< imageio, Pillow, matplotlib
  BGR,  ///< OpenCV
};

/// A float image of one channel, seen in place. Throws ShapeError for any other, or without pixels.
PlaneView<float> plane_view(const ImageView& image);

/// Grey values 0..255 as float: uint8 as is, uint16 / 257, float as is; colour is
/// 0.299 R + 0.587 G + 0.114 B (luma of ITU-R BT.601, as OpenCV). Non-finite pixels stay what they
/// are: they stand for "no data", and whatever reads one is not finite either. Throws ShapeError
/// for an empty or invalid view.
void to_grey(const ImageView& image, ColorOrder order, Plane<float>& grey);

/// The same without a copy of what is grey float already: such an image is seen in place, another
/// is converted into `memory`.
PlaneView<float> grey_view(const ImageView& image, ColorOrder order, Plane<float>& memory);

}  // namespace raylign
