// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/row_caster.h"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace raylign::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

RowCaster::RowCaster(const RenderScene& scene, const RadtanCamera& camera, double footprint)
    : scene_(scene),
      camera_(camera),
      footprint_(footprint),
      is_distorted_(!camera.params().tail<5>().isZero(0.0)),
      max_radius_squared_(camera.distortion().max_radius_squared()) {}

void RowCaster::aim(double u, double step, double v, int size) {
  const PinholeCamera& K = camera_.pinhole();
  const Matrix3 R_wc = R_cw_.transpose();
  size_ = size;
  direction_.resize(size);
  by_u_.resize(size);
  by_v_.resize(size);
  for (int i = 0; i < size; ++i) {
    Vector2 p((u + i * step - K.cx()) / K.fx(), (v - K.cy()) / K.fy());
    RowMajor<2, 2> J_pixel = Vector2(1.0 / K.fx(), 1.0 / K.fy()).asDiagonal();
    if (is_distorted_) {
      const Vector2 p_distorted = p;
      RowMajor<2, 2> J_p;
      if (camera_.distortion().undistort(p_distorted, max_radius_squared_, p, J_p)) {
        J_pixel = RowMajor<2, 2>(J_p.inverse() * J_pixel);
      } else {
        p.setConstant(kNan);
      }
    }
    direction_[i] = R_wc * Vector3(p.x(), p.y(), 1.0);
    by_u_[i] = R_wc.leftCols<2>() * J_pixel.col(0);
    by_v_[i] = R_wc.leftCols<2>() * J_pixel.col(1);
  }
}

void RowCaster::cast(const Matrix4& T_cw, double u, double step, double v, int size) {
  R_cw_ = T_cw.topLeftCorner<3, 3>();
  center_ = -(R_cw_.transpose() * T_cw.topRightCorner<3, 1>());
  aim(u, step, v, size);
  depth_.assign(size, kInfinity);
  face_.assign(size, -1);
  local_.resize(size);
  Hits hits{depth_.data(), face_.data()};
  for (const RenderScene::Placed& placed : scene_.surfaces()) {
    for (int i = 0; i < size; ++i) local_[i] = placed.R_sw * direction_[i];
    const Rays rays{size, placed.R_sw * center_ + placed.t_sw, local_.data()};
    placed.surface->intersect(rays, placed.first_face, hits);
  }
  group_by_face();
}

// Counting sort: the textures want long runs of points, and faces alternate along a row.
void RowCaster::group_by_face() {
  const std::size_t num_faces = scene_.faces().size();
  face_begin_.assign(num_faces + 1, 0);
  for (const int face : face_) {
    if (face >= 0) ++face_begin_[face + 1];
  }
  for (std::size_t f = 0; f < num_faces; ++f) face_begin_[f + 1] += face_begin_[f];
  std::vector<int> next(face_begin_.begin(), face_begin_.end() - 1);
  order_.resize(face_begin_.back());
  for (int i = 0; i < size_; ++i) {
    if (face_[i] >= 0) order_[next[face_[i]]++] = i;
  }
}

void RowCaster::locate(int face, int begin, int end) {
  const RenderScene::Face& f = scene_.faces()[face];
  const RenderScene::Placed& placed = scene_.surfaces()[f.surface];
  const int count = end - begin;
  point_.resize(count);
  surface_point_.resize(count);
  normal_.resize(count);
  for (int k = 0; k < count; ++k) {
    const int i = order_[begin + k];
    point_[k] = center_ + depth_[i] * direction_[i];
    surface_point_[k] = placed.R_sw * point_[k] + placed.t_sw;
  }
  placed.surface->normals(f.index, count, surface_point_.data(), normal_.data());
  for (Vector3& normal : normal_) normal = placed.R_sw.transpose() * normal;
}

// The kernels' layout: structure of arrays, padded with copies of the first point. A step of one
// pixel moves the point within the tangent plane: dp = t (dd − d (n · dd) / (n · d)).
void RowCaster::lay_out(int face, int begin, int count, int padded) {
  const RenderScene::Face& f = scene_.faces()[face];
  for (auto* arrays : {position_, footprint_u_, footprint_v_}) {
    for (int axis = 0; axis < 3; ++axis) arrays[axis].resize(padded);
  }
  value_.resize(padded);
  for (int k = 0; k < padded; ++k) {
    const int source = k < count ? k : 0;
    const int i = order_[begin + source];
    const Vector3& n = normal_[source];
    const Vector3& d = direction_[i];
    const double scale = footprint_ * depth_[i];
    const Vector3 along = d / n.dot(d);
    const Vector3 x = f.R_xw * point_[source] + f.t_xw;
    const Vector3 x_u = f.R_xw * (scale * (by_u_[i] - along * n.dot(by_u_[i])));
    const Vector3 x_v = f.R_xw * (scale * (by_v_[i] - along * n.dot(by_v_[i])));
    for (int axis = 0; axis < 3; ++axis) {
      position_[axis][k] = x[axis];
      footprint_u_[axis][k] = x_u[axis];
      footprint_v_[axis][k] = x_v[axis];
    }
  }
}

void RowCaster::shade(double background, double* irradiance) {
  std::fill_n(irradiance, size_, background);
  for (std::size_t face = 0; face + 1 < face_begin_.size(); ++face) {
    const int begin = face_begin_[face];
    const int count = face_begin_[face + 1] - begin;
    if (count == 0) continue;
    const int padded = (count + kPointBlock - 1) / kPointBlock * kPointBlock;
    locate(static_cast<int>(face), begin, begin + count);
    lay_out(static_cast<int>(face), begin, count, padded);
    WavePoints points;
    points.size = padded;
    for (int axis = 0; axis < 3; ++axis) {
      points.position[axis] = position_[axis].data();
      points.by_u[axis] = footprint_u_[axis].data();
      points.by_v[axis] = footprint_v_[axis].data();
    }
    const Texture& texture = *scene_.faces()[face].texture;
    if (footprint_ > 0.0) {
      texture.evaluate_banded(points, value_.data());
    } else {
      texture.evaluate(points, value_.data());
    }
    for (int k = 0; k < count; ++k) irradiance[order_[begin + k]] = value_[k];
  }
}

void RowCaster::measure(double* depth, double* normal, std::int32_t* face) {
  for (int i = 0; i < size_; ++i) {
    depth[i] = face_[i] < 0 ? kNan : depth_[i];
    face[i] = face_[i];
  }
  std::fill_n(normal, 3 * size_, kNan);
  for (std::size_t f = 0; f + 1 < face_begin_.size(); ++f) {
    const int begin = face_begin_[f];
    const int end = face_begin_[f + 1];
    if (begin == end) continue;
    locate(static_cast<int>(f), begin, end);
    for (int k = begin; k < end; ++k) {
      const int i = order_[k];
      const Vector3 n = R_cw_ * normal_[k - begin].normalized();
      const double sign = normal_[k - begin].dot(direction_[i]) > 0.0 ? -1.0 : 1.0;
      Eigen::Map<Vector3>(normal + 3 * i) = sign * n;
    }
  }
}

}  // namespace raylign::render
