// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raylign/base/error.h"

namespace raylign {

/// Non-owning view of one value of type T per pixel: float images, depth maps, GradientCells.
template <typename T>
struct PlaneView {
  const T* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< in T, from one row to the next, >= width

  bool empty() const { return width == 0 || height == 0; }
  const T* row(int v) const { return data + v * stride; }
  const T& at(int u, int v) const { return row(v)[u]; }

  /// The samplers' rule: 0 <= u <= width - 1 and 0 <= v <= height - 1; false for NaN.
  template <typename Scalar>
  bool contains(Scalar u, Scalar v) const {
    return u >= Scalar(0) && u <= Scalar(width - 1) && v >= Scalar(0) && v <= Scalar(height - 1);
  }
};

/// Owning plane, rows without padding. resize() keeps its memory, so that a plane that is rebuilt
/// for every frame allocates once.
template <typename T>
class Plane {
 public:
  Plane() = default;
  Plane(int width, int height) { resize(width, height); }

  /// Leaves the values unspecified. Throws ShapeError for a negative size.
  void resize(int width, int height) {
    if (width < 0 || height < 0) {
      throw ShapeError("image size must be >= 0, got " + std::to_string(width) + " x " +
                       std::to_string(height));
    }
    values_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    width_ = width;
    height_ = height;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return values_.empty(); }
  std::size_t size() const { return values_.size(); }

  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }
  T* row(int v) { return data() + static_cast<std::ptrdiff_t>(v) * width_; }
  const T* row(int v) const { return data() + static_cast<std::ptrdiff_t>(v) * width_; }
  T& at(int u, int v) { return row(v)[u]; }
  const T& at(int u, int v) const { return row(v)[u]; }

  /// Valid until this plane is resized, assigned to or destroyed.
  PlaneView<T> view() const { return {data(), width_, height_, width_}; }

 private:
  std::vector<T> values_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace raylign
