// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "raylign/image/bspline.h"
#include "raylign/image/plane.h"
#include "raylign/image/pyramid.h"
#include "raylign/image/sample_points.h"

namespace raylign {

/// One level of an image as patches read it. `origin` points at the value (CUBIC_BSPLINE: the
/// coefficient) of pixel (0, 0); what interpolation reads around a position inside the bounds is
/// there, without a test for the border.
struct PatchPlane {
  const float* origin = nullptr;
  std::ptrdiff_t stride = 0;  ///< floats from one row to the next
  double max_u = -1.0;        ///< a pixel at (u, v) is seen where 0 <= u <= max_u, 0 <= v <= max_v
  double max_v = -1.0;

  bool contains(double u, double v) const {
    return u >= 0.0 && u <= max_u && v >= 0.0 && v <= max_v;
  }
};

/// What lies behind the right border of a row.
enum class PatchBorder {
  REPLICATE,  ///< the border pixel; pixels are seen up to size − 1
  WRAP,       ///< whatever follows in memory, and pixels are seen up to just below `size`: the
              ///< bounds of the original exercise, for its preset
};

/// The pyramid of one image, interpolation prepared, values in grey levels 0..255.
class PatchImage {
 public:
  PatchImage(const ImagePyramid& pyramid,
             SampleInterpolation interpolation,
             PatchBorder border = PatchBorder::REPLICATE);
  PatchImage(PatchImage&&) = default;  // the planes point into this object's own memory
  PatchImage& operator=(PatchImage&&) = default;

  int num_levels() const { return static_cast<int>(planes_.size()); }
  const PatchPlane& plane(int level) const { return planes_[static_cast<std::size_t>(level)]; }
  int width(int level) const { return sizes_[static_cast<std::size_t>(level)][0]; }
  int height(int level) const { return sizes_[static_cast<std::size_t>(level)][1]; }

 private:
  void add_spline(const PlaneView<float>& image);
  void add_padded(const PlaneView<float>& image, PatchBorder border);

  std::vector<BSplineImage> splines_;
  std::vector<Plane<float>> padded_;
  std::vector<PatchPlane> planes_;
  std::vector<std::array<int, 2>> sizes_;
};

/// Value and gradient (per px of the level) at a position that plane.contains().
Sample<double> sample_patch_plane(const PatchPlane& plane,
                                  SampleInterpolation interpolation,
                                  double u,
                                  double v);

}  // namespace raylign
