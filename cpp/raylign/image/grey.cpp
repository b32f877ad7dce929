// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/grey.h"

#include <algorithm>

#include "raylign/image/kernels.h"

namespace raylign {
namespace {

image_kernels::GreyWeights weights_of(ColorOrder order) {
  constexpr float kRed = 0.299F;
  constexpr float kGreen = 0.587F;
  constexpr float kBlue = 0.114F;
  if (order == ColorOrder::RGB) return {{kRed, kGreen, kBlue}};
  return {{kBlue, kGreen, kRed}};
}

void widen(const float* in, int n, float* out) { std::copy(in, in + n, out); }
void widen(const std::uint8_t* in, int n, float* out) { image_kernels::widen(in, n, out); }
void widen(const std::uint16_t* in, int n, float* out) { image_kernels::widen(in, n, out); }

template <typename Pixel>
void convert(const ImageView& image, ColorOrder order, Plane<float>& grey) {
  const auto* bytes = static_cast<const std::byte*>(image.data);
  for (int v = 0; v < image.height; ++v) {
    const auto* row = reinterpret_cast<const Pixel*>(bytes + v * image.row_stride);
    if (image.channels == 1) {
      widen(row, image.width, grey.row(v));
    } else {
      image_kernels::to_grey(row, image.width, weights_of(order), grey.row(v));
    }
  }
}

}  // namespace

PlaneView<float> plane_view(const ImageView& image) {
  image.validate();
  if (image.empty()) throw ShapeError("image must have at least one pixel");
  if (image.type != PixelType::FLOAT32 || image.channels != 1) {
    throw ShapeError("image must have one channel of float32");
  }
  return {static_cast<const float*>(image.data), image.width, image.height,
          static_cast<std::ptrdiff_t>(image.row_stride / sizeof(float))};
}

void to_grey(const ImageView& image, ColorOrder order, Plane<float>& grey) {
  image.validate();
  if (image.empty()) throw ShapeError("image must have at least one pixel");
  grey.resize(image.width, image.height);
  switch (image.type) {
    case PixelType::UINT8:
      return convert<std::uint8_t>(image, order, grey);
    case PixelType::UINT16:
      return convert<std::uint16_t>(image, order, grey);
    case PixelType::FLOAT32:
      return convert<float>(image, order, grey);
  }
}

PlaneView<float> grey_view(const ImageView& image, ColorOrder order, Plane<float>& memory) {
  if (image.type == PixelType::FLOAT32 && image.channels == 1) return plane_view(image);
  to_grey(image, order, memory);
  return memory.view();
}

}  // namespace raylign
