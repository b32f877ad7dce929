// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <vector>

#include "raylign/camera/pinhole.h"
#include "raylign/image/depth_pyramid.h"
#include "raylign/image/gradient.h"
#include "raylign/image/image_view.h"
#include "raylign/image/pyramid.h"
#include "raylign/tracking/kernels.h"

namespace raylign {

/// An image, rectified, and what tracking derives from it: pyramid, gradients and, where there is a
/// depth map, inverse depth. A frame is tracked, and may become a keyframe. Levels are prepared
/// when they are first asked for; that is safe from several threads, assign and set_depth are not.
class Frame {
 public:
  Frame(const ImageView& image, const PinholeCamera& camera, int max_levels = 5) : camera_(camera) {
    assign(image, camera, max_levels);
  }

  /// Rebuilds from another image, without depth; memory is reused. Throws ShapeError, OptionsError.
  void assign(const ImageView& image, const PinholeCamera& camera, int max_levels = 5);
  /// Inverse depth D (1 / scene unit) and its variance per pixel of level 0; a pixel has depth
  /// where both are positive and finite. Throws ShapeError when a size is not the image's.
  void set_depth(const PlaneView<float>& inverse_depth, const PlaneView<float>& variance);

  /// As set_depth, of maps that are both 0 or both positive and finite in every pixel; takes them
  /// without a copy and leaves earlier ones in their place.
  void adopt_depth(Plane<float>& inverse_depth, Plane<float>& variance);

  int num_levels() const { return images_.num_levels(); }
  int width(int level) const { return images_.level(level).width(); }
  int height(int level) const { return images_.level(level).height(); }
  /// Of a level; the half-pixel rule.
  PinholeCamera camera(int level) const { return camera_.at_level(level); }
  bool has_depth() const { return has_depth_; }

  const ImagePyramid& images() const { return images_; }
  const DepthPyramid& depth() const { return depth_; }
  const GradientImage& gradients(int level) const;
  const Plane<tracking::DepthCell>& depth_cells(int level) const;

 private:
  template <typename T>
  struct Lazy {
    T value;
    bool is_ready = false;
  };

  DepthPyramidOptions depth_options(int width, int height) const;
  void start_depth();

  PinholeCamera camera_;
  ImagePyramid images_;
  DepthPyramid depth_;
  bool has_depth_ = false;
  mutable std::vector<Lazy<GradientImage>> gradients_;
  mutable std::vector<Lazy<Plane<tracking::DepthCell>>> depth_cells_;
  mutable std::mutex mutex_;
};

}  // namespace raylign
