// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/undistort.h"

#include <Eigen/LU>
#include <string>

#include "raylign/base/error.h"

namespace raylign {
namespace {

Matrix3 checked_inverse(const Matrix3& K_new) {
  Matrix3 inverse;
  bool invertible = false;
  K_new.computeInverseWithCheck(inverse, invertible);
  if (!K_new.allFinite() || !invertible) {
    throw OptionsError("undistort_map: K_new must be finite and invertible");
  }
  return inverse;
}

template <typename Camera>
UndistortMap make_map(const Camera& camera, const Matrix3& K_new, int width, int height) {
  if (width < 1 || height < 1) {
    throw ShapeError("undistort_map: width and height must be >= 1, got " + std::to_string(width) +
                     " x " + std::to_string(height));
  }
  const Matrix3 K_inverse = checked_inverse(K_new);
  UndistortMap map;
  map.map_x.setConstant(height, width, UndistortMap::kOutside);
  map.map_y.setConstant(height, width, UndistortMap::kOutside);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      Vector2 uv;
      if (!camera.project(K_inverse * Vector3(u, v, 1.0), uv)) continue;
      map.map_x(v, u) = static_cast<float>(uv.x());
      map.map_y(v, u) = static_cast<float>(uv.y());
    }
  }
  return map;
}

}  // namespace

UndistortMap undistort_map(const PinholeCamera& camera,
                           const Matrix3& K_new,
                           int width,
                           int height) {
  return make_map(camera, K_new, width, height);
}

UndistortMap undistort_map(const RadtanCamera& camera,
                           const Matrix3& K_new,
                           int width,
                           int height) {
  return make_map(camera, K_new, width, height);
}

}  // namespace raylign
