// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace raylign {

enum class PixelType {
  UINT8,
  UINT16,
  FLOAT32,
};

/// Bytes of one channel of one pixel.
constexpr std::size_t pixel_size(PixelType type) {
  return type == PixelType::UINT8 ? 1 : (type == PixelType::UINT16 ? 2 : 4);
}

/// Non-owning view of an image in somebody else's memory: row v starts at data + v * row_stride,
/// the channels of a pixel are interleaved, pixels of a row follow each other without gap.
struct ImageView {
  const void* data = nullptr;
  PixelType type = PixelType::UINT8;
  int width = 0;
  int height = 0;
  int channels = 1;            ///< 1 or 3
  std::size_t row_stride = 0;  ///< bytes, >= width * channels * pixel_size(type)

  bool empty() const { return width == 0 || height == 0; }
  std::size_t row_bytes() const { return pixel_size(type) * channels * width; }
  /// Throws ShapeError for a negative size, another number of channels, a stride shorter than a row
  /// or one that does not fit the pixel type, or a null pointer where there are pixels.
  void validate() const;
};

}  // namespace raylign
