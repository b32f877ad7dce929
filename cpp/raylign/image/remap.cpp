// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/remap.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "raylign/base/error.h"

namespace raylign {
namespace {

constexpr int kMaxSide = 32766;  // cv::remap keeps coordinates in short integers

int cv_type(PixelType type, int channels) {
  switch (type) {
    case PixelType::UINT8:
      return CV_MAKETYPE(CV_8U, channels);
    case PixelType::UINT16:
      return CV_MAKETYPE(CV_16U, channels);
    case PixelType::FLOAT32:
      break;
  }
  return CV_MAKETYPE(CV_32F, channels);
}

int cv_interpolation(Interpolation interpolation) {
  switch (interpolation) {
    case Interpolation::NEAREST:
      return cv::INTER_NEAREST;
    case Interpolation::LINEAR:
      break;
    case Interpolation::CUBIC:
      return cv::INTER_CUBIC;
  }
  return cv::INTER_LINEAR;
}

void check_side(const char* what, Eigen::Index side) {
  if (side >= 1 && side <= kMaxSide) return;
  throw ShapeError(std::string("remap: ") + what + " must be in [1, " + std::to_string(kMaxSide) +
                   "], got " + std::to_string(side));
}

// OpenCV takes non-const headers also of what it only reads.
cv::Mat header(const CoordinateMap& map) {
  return cv::Mat(static_cast<int>(map.rows()), static_cast<int>(map.cols()), CV_32FC1,
                 const_cast<float*>(map.data()), sizeof(float) * map.outerStride());
}

}  // namespace

Image remap(const ImageView& image,
            const CoordinateMap& map_x,
            const CoordinateMap& map_y,
            Interpolation interpolation) {
  image.validate();
  if (map_x.rows() != map_y.rows() || map_x.cols() != map_y.cols()) {
    throw ShapeError("remap: map_x and map_y must have the same shape");
  }
  check_side("width of the image", image.width);
  check_side("height of the image", image.height);
  check_side("width of the maps", map_x.cols());
  check_side("height of the maps", map_x.rows());
  const int type = cv_type(image.type, image.channels);
  Image result(image.type, static_cast<int>(map_x.cols()), static_cast<int>(map_x.rows()),
               image.channels);
  const cv::Mat source(image.height, image.width, type, const_cast<void*>(image.data),
                       image.row_stride);
  cv::Mat target(result.height(), result.width(), type, result.data(), result.row_stride());
  try {
    cv::remap(source, target, header(map_x), header(map_y), cv_interpolation(interpolation),
              cv::BORDER_CONSTANT, cv::Scalar::all(0.0));
  } catch (const cv::Exception& error) {
    throw Error(std::string("remap: OpenCV failed: ") + error.what());
  }
  return result;
}

}  // namespace raylign
