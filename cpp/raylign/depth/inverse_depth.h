// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/depth/depth_model.h"
#include "raylign/image/image_view.h"

namespace raylign {

/// Turns the depth images of a sensor into what a tracker reads: inverse depth D (1/m) and its
/// variance V (1/m²), both 0 where there is no trusted depth. Keeps its buffers from one image to
/// the next.
class InverseDepthConverter {
 public:
  /// Throws OptionsError.
  explicit InverseDepthConverter(const DepthModel& model);

  /// @param depth  one channel: FLOAT32 in m, or UINT16 in units of 1/depth_scale m (`depth_scale`
  ///               5000 for TUM, 1000 for mm). 0, 65535, NaN, infinite and out of range: no depth.
  /// @param D, V   (height, width) row-major, written whole.
  /// Throws ShapeError for another pixel type or number of channels, OptionsError for depth_scale
  /// not > 0.
  void convert(const ImageView& depth, double depth_scale, float* D, float* V);

  /// Throws as `convert` does for this image.
  void check(const ImageView& depth, double depth_scale) const;

  const DepthModel& model() const { return model_; }

 private:
  void invert_row(const ImageView& depth, double depth_scale, int v, float* D) const;
  float* ring_row(std::vector<float>& ring, int v, int width);
  void start_row(const float* D, int v, int width);
  void finish_row(int v, int width, int height, float* D, float* V);

  DepthModel model_;
  std::vector<float> low_, high_;  ///< the last rows' extremes along the row
};

}  // namespace raylign
