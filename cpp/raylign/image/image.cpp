// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/image.h"

#include <string>

#include "raylign/base/error.h"

namespace raylign {

void ImageView::validate() const {
  if (width < 0 || height < 0) {
    throw ShapeError("image size must be >= 0, got " + std::to_string(width) + " x " +
                     std::to_string(height));
  }
  if (channels != 1 && channels != 3) {
    throw ShapeError("an image must have 1 or 3 channels, got " + std::to_string(channels));
  }
  if (row_stride < row_bytes() || row_stride % pixel_size(type) != 0) {
    throw ShapeError("row stride of " + std::to_string(row_stride) +
                     " bytes does not fit rows of " + std::to_string(row_bytes()) + " bytes");
  }
  if (data == nullptr && !empty()) throw ShapeError("image has a size but no data");
}

Image::Image(PixelType type, int width, int height, int channels)
    : type_(type), width_(width), height_(height), channels_(channels) {
  const std::byte placeholder{};
  ImageView view;
  view.data = &placeholder;  // checks the size before any memory is asked for
  view.type = type;
  view.width = width;
  view.height = height;
  view.channels = channels;
  view.row_stride = view.row_bytes();
  view.validate();
  bytes_.resize(view.row_stride * static_cast<std::size_t>(height));
}

ImageView Image::view() const {
  ImageView view;
  view.data = bytes_.data();
  view.type = type_;
  view.width = width_;
  view.height = height_;
  view.channels = channels_;
  view.row_stride = view.row_bytes();
  return view;
}

}  // namespace raylign
