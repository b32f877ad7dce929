// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "raylign/image/image_view.h"

namespace raylign {

/// Owning image, rows without padding.
class Image {
 public:
  Image() = default;
  /// Zero-filled. Throws ShapeError for a size that ImageView::validate refuses.
  Image(PixelType type, int width, int height, int channels);

  PixelType type() const { return type_; }
  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  std::size_t row_stride() const { return view().row_bytes(); }

  const void* data() const { return bytes_.data(); }
  void* data() { return bytes_.data(); }
  /// Valid as long as this image lives and is not assigned to.
  ImageView view() const;

 private:
  PixelType type_ = PixelType::UINT8;
  int width_ = 0;
  int height_ = 0;
  int channels_ = 1;
  std::vector<std::byte> bytes_;
};

}  // namespace raylign
