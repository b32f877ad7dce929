// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/camera/radtan.h"
#include "raylign/synthetic/render/scene.h"

namespace raylign::render {

/// Casts the rays of one image row at a time and tells what they see. Holds scratch memory: one per
/// task.
class RowCaster {
 public:
  /// `footprint` scales the pixel that the texture is band-limited for; 0: no band limit.
  RowCaster(const RenderScene& scene, const RadtanCamera& camera, double footprint);

  /// Rays through (u + i · step, v), i < size.
  void cast(const Matrix4& T_cw, double u, double step, double v, int size);

  /// Grey values of the cast row, `background` where nothing was met.
  void shade(double background, double* irradiance);
  /// Depth z, unit normal towards the camera (camera frame) and face of the cast row; NaN and −1
  /// where nothing was met. `normal` holds three values per ray.
  void measure(double* depth, double* normal, std::int32_t* face);

 private:
  void aim(double u, double step, double v, int size);
  void group_by_face();
  /// World points and normals of the rays order_[begin, end), all on one face.
  void locate(int face, int begin, int end);
  void lay_out(int face, int begin, int count, int padded);

  const RenderScene& scene_;
  const RadtanCamera& camera_;
  const double footprint_;
  const bool is_distorted_;
  const double max_radius_squared_;

  Matrix3 R_cw_;
  Vector3 center_;
  int size_ = 0;
  std::vector<Vector3> direction_;    // world frame, camera z = 1; NaN: no ray
  std::vector<Vector3> by_u_, by_v_;  // d(direction)/d(pixel)
  std::vector<Vector3> local_;        // directions in the frame of a surface
  std::vector<double> depth_;
  std::vector<int> face_;
  std::vector<int> order_, face_begin_;  // rays sorted by face; where each face begins
  std::vector<Vector3> point_, surface_point_, normal_;  // of one face, world frame
  std::vector<double> position_[3], footprint_u_[3], footprint_v_[3], value_;
};

}  // namespace raylign::render
