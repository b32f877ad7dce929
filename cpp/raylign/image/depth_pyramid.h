// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "raylign/image/plane.h"
#include "raylign/image/pyramid.h"

namespace raylign {

struct DepthPyramidOptions {
  PyramidOptions pyramid;  ///< as of the image beside it
  /// > 1: four pixels whose depths differ by more than this factor straddle a depth edge, and their
  /// parent has no depth. Infinite (the paper's rule): they are averaged. The factor sees slant,
  /// too: at level l a plane inclined by angle a spans about 1 + 2^l tan(a) / f between neighbours.
  double max_depth_ratio = std::numeric_limits<double>::infinity();

  /// Throws OptionsError.
  void validate() const;
};

/// Inverse depth D (1 / scene unit) and its variance V per level. A pixel has depth iff D and V are
/// positive and finite; all others hold (0, 0) on every level, so that V > 0 is the whole test. A
/// parent of n >= 1 pixels with depth has D = sum(D / V) / sum(1 / V) and V = n / sum(1 / V): their
/// errors count as one, averaging does not shrink them (Engel, Schöps, Cremers, ECCV 2014, code).
class DepthPyramid {
 public:
  DepthPyramid() = default;
  DepthPyramid(const PlaneView<float>& inverse_depth,
               const PlaneView<float>& variance,
               const DepthPyramidOptions& options = {}) {
    assign(inverse_depth, variance, options);
  }

  /// Rebuilds; memory is reused as by ImagePyramid. Throws ShapeError when the maps are empty or
  /// differ in size, OptionsError.
  void assign(const PlaneView<float>& inverse_depth,
              const PlaneView<float>& variance,
              const DepthPyramidOptions& options = {});

  /// As assign, of maps that keep to the rule above already (both 0, or both positive and finite).
  /// Takes them without a copy and leaves earlier ones in their place.
  void adopt(Plane<float>& inverse_depth,
             Plane<float>& variance,
             const DepthPyramidOptions& options = {});

  int num_levels() const { return static_cast<int>(levels_.size()); }
  const Plane<float>& inverse_depth(int l) const { return levels_[l].D; }
  const Plane<float>& variance(int l) const { return levels_[l].V; }

 private:
  struct Level {
    Plane<float> D;
    Plane<float> V;
  };

  void make_levels(int width, int height, const DepthPyramidOptions& options);
  void halve(const DepthPyramidOptions& options);

  std::vector<Level> levels_;
};

}  // namespace raylign
