// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/scene.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "raylign/base/error.h"
#include "raylign/synthetic/render/check_pose.h"

namespace raylign {
namespace {

void require_size(const char* name, double value, bool may_be_infinite = false) {
  require_option(value > 0.0 && (may_be_infinite || std::isfinite(value)), name,
                 may_be_infinite ? "> 0" : "finite and > 0", value);
}

}  // namespace

void require_rigid(const char* name, const Matrix4& T) {
  constexpr double kTolerance = 1e-6;
  const Matrix3 R = T.topLeftCorner<3, 3>();
  const bool is_rigid = T.allFinite() && (R * R.transpose()).isIdentity(kTolerance) &&
                        R.determinant() > 0.0 && T.row(3) == Vector4::Unit(3).transpose();
  if (!is_rigid) {
    throw OptionsError(std::string(name) + " must be a rigid transform [R t; 0 1], got one that " +
                       (T.allFinite() ? "is not" : "is not finite"));
  }
}

void RenderScene::place(std::shared_ptr<const render::Surface> surface,
                        const Matrix4& T_ws,
                        const TextureOptions& texture) {
  require_rigid("T_ws", T_ws);
  texture.validate();
  const Matrix3 R_sw = T_ws.topLeftCorner<3, 3>().transpose();
  const Vector3 t_sw = -R_sw * T_ws.topRightCorner<3, 1>();
  const int first_face = static_cast<int>(faces_.size());
  for (int i = 0; i < surface->num_faces(); ++i) {
    const Matrix3 map = surface->texture_map(i);
    faces_.push_back({render::make_texture(texture, surface->texture_space(), i), map * R_sw,
                      map * t_sw, static_cast<int>(surfaces_.size()), i});
  }
  surfaces_.push_back({std::move(surface), R_sw, t_sw, first_face});
}

void RenderScene::add_box(const Matrix4& T_ws, const Vector3& size, const TextureOptions& texture) {
  for (int axis = 0; axis < 3; ++axis) require_size("box size", size[axis]);
  place(render::make_box(size), T_ws, texture);
}

void RenderScene::add_rectangle(const Matrix4& T_ws,
                                double width,
                                double height,
                                const TextureOptions& texture) {
  require_size("rectangle width", width, true);
  require_size("rectangle height", height, true);
  place(render::make_rectangle(width, height), T_ws, texture);
}

void RenderScene::add_sphere(const Matrix4& T_ws, double radius, const TextureOptions& texture) {
  require_size("sphere radius", radius);
  place(render::make_sphere(radius), T_ws, texture);
}

void RenderScene::add_height_field(const Matrix4& T_ws,
                                   const HeightFieldOptions& options,
                                   const TextureOptions& texture) {
  options.validate();
  place(render::make_height_field(options), T_ws, texture);
}

double RenderScene::grey_value(int face, const Vector3& p_w, Vector3* gradient) const {
  constexpr int kBlock = render::kPointBlock;
  const Face& f = faces_[face];
  const Vector3 x = f.R_xw * p_w + f.t_xw;
  double position[3][kBlock], value[kBlock], slope[3][kBlock];
  render::WavePoints points;
  points.size = kBlock;
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(position[axis], kBlock, x[axis]);
    points.position[axis] = position[axis];
  }
  double* const slopes[3] = {slope[0], slope[1], slope[2]};
  f.texture->evaluate_with_gradient(points, value, slopes);
  if (gradient) {
    *gradient = f.R_xw.transpose() * Vector3(slope[0][0], slope[1][0], slope[2][0]);
  }
  return value[0];
}

void RenderScene::add(const RenderScene& other) {
  const std::size_t num_surfaces = other.surfaces_.size();  // other may be this scene
  const std::size_t num_faces = other.faces_.size();
  const int surface_shift = static_cast<int>(surfaces_.size());
  const int face_shift = static_cast<int>(faces_.size());
  for (std::size_t i = 0; i < num_faces; ++i) {
    Face face = other.faces_[i];
    face.surface += surface_shift;
    faces_.push_back(std::move(face));
  }
  for (std::size_t i = 0; i < num_surfaces; ++i) {
    Placed placed = other.surfaces_[i];
    placed.first_face += face_shift;
    surfaces_.push_back(std::move(placed));
  }
}

}  // namespace raylign
