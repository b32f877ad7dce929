// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstring>
#include <vector>

#include "raylign/ceres_backend/point_blocks.h"
#include "raylign/parametrization/constants.h"
#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_options.h"

namespace raylign::ceres_backend {

/// How one point is stored in its block.
enum class PointModel { XYZ, HOMOGENEOUS, INVERSE_DEPTH };

/// The numbers that Ceres moves: camera by camera pose and intrinsics, then the points, in the
/// chosen parametrisation; and the way from a scene and back.
///
/// All blocks lie in one buffer, because Ceres orders the blocks of an elimination group by
/// address: with separate buffers the allocator would choose the order of the sums, and with it the
/// last bits.
template <typename Camera, typename Pose>
class ParameterState {
 public:
  ParameterState(const BundleScene& scene,
                 PointParametrization parametrization,
                 const Constants& held)
      : scene_(scene), parametrization_(parametrization), held_(held) {
    find_hosts();
    frame_ = homogeneous_frame(scene);
    point_size_ = parametrization == PointParametrization::HOMOGENEOUS ? 4 : 3;
    points_offset_ = scene.num_cameras() * kCameraStride;
    values_.resize(points_offset_ + scene.num_points() * point_size_);
    for (std::int64_t c = 0; c < scene.num_cameras(); ++c) load_camera(c);
    for (std::int64_t p = 0; p < scene.num_points(); ++p) load_point(p);
    initial_values_ = values_;
  }
  ParameterState(const ParameterState&) = delete;  // Ceres keeps the addresses
  ParameterState& operator=(const ParameterState&) = delete;

  double* pose(std::int64_t c) { return values_.data() + c * kCameraStride; }
  double* intrinsics(std::int64_t c) { return pose(c) + Pose::kSize; }
  double* point(std::int64_t p) { return values_.data() + points_offset_ + p * point_size_; }

  const HomogeneousFrame& frame() const { return frame_; }

  /// First camera (lowest index) that sees point p: where an inverse-depth point is anchored. −1:
  /// nobody.
  std::int32_t host(std::int64_t p) const { return hosts_[p]; }

  /// A held point stays what it is in world coordinates, whatever the parametrisation of the
  /// others.
  PointModel point_model(std::int64_t p) const {
    switch (parametrization_) {
      case PointParametrization::HOMOGENEOUS:
        return PointModel::HOMOGENEOUS;
      case PointParametrization::INVERSE_DEPTH:
        return held_.holds_point(p) ? PointModel::XYZ : PointModel::INVERSE_DEPTH;
      case PointParametrization::XYZ:
        break;
    }
    return PointModel::XYZ;
  }

  void save() { saved_values_ = values_; }
  void restore_saved() { values_ = saved_values_; }

  /// Writes the state into `scene`; numbers of blocks that still hold their first bits are left
  /// alone.
  void write_back(BundleScene& scene) const {
    for (std::int64_t c = 0; c < scene.num_cameras(); ++c) write_back_camera(c, scene);
    for (std::int64_t p = 0; p < scene.num_points(); ++p) {
      if (changed(points_offset_ + p * point_size_, point_size_) || host_moved(p)) {
        scene.points.row(p) = world_point(p).transpose();
      }
    }
  }

 private:
  static constexpr std::int64_t kCameraStride = Pose::kSize + Camera::kNumParams;

  const double* pose(std::int64_t c) const { return values_.data() + c * kCameraStride; }

  void find_hosts() {
    hosts_.assign(scene_.num_points(), -1);
    for (std::int64_t i = 0; i < scene_.num_observations(); ++i) {
      std::int32_t& host = hosts_[scene_.point_index[i]];
      const std::int32_t camera = scene_.camera_index[i];
      if (host < 0 || camera < host) host = camera;
    }
  }

  void load_camera(std::int64_t c) {
    Pose::from_angle_axis(scene_.omega.row(c).transpose(), scene_.t.row(c).transpose(), pose(c));
    Eigen::Map<typename Camera::Params>{intrinsics(c)} = scene_.intrinsics.row(c).transpose();
  }

  void load_point(std::int64_t p) {
    const Vector3 x = scene_.points.row(p).transpose();
    switch (point_model(p)) {
      case PointModel::XYZ:
        Eigen::Map<Vector3>{point(p)} = x;
        return;
      case PointModel::HOMOGENEOUS:
        Eigen::Map<Vector4>{point(p)} = frame_.from_world(x);
        return;
      case PointModel::INVERSE_DEPTH:
        break;
    }
    if (hosts_[p] < 0) return;  // never observed: never read
    const Pose host(pose(hosts_[p]));
    const Vector3 p_h = host.R_cw * x + host.t_cw;
    const double rho = Camera::kViewZ / p_h.z();  // m = ρ p_h with m_z = ±1: where the host looks
    Eigen::Map<Vector3>{point(p)} = rho * Vector3(p_h.x(), p_h.y(), 1.0);
  }

  bool changed(std::int64_t offset, std::int64_t count) const {
    return std::memcmp(&values_[offset], &initial_values_[offset], count * sizeof(double)) != 0;
  }

  void write_back_camera(std::int64_t c, BundleScene& scene) const {
    const double* block = pose(c);
    const std::int64_t first = c * kCameraStride;
    constexpr std::int64_t kRotationSize = Pose::kSize - 3;
    if (changed(first, kRotationSize)) {  // a held rotation keeps the file's digits
      scene.omega.row(c) = Pose::angle_axis(block).transpose();
    }
    // Translation and intrinsics are the scene's own numbers: unchanged ones are copied onto
    // themselves.
    scene.t.row(c) = Eigen::Map<const Vector3>(block + kRotationSize).transpose();
    scene.intrinsics.row(c) =
        Eigen::Map<const typename Camera::Params>(block + Pose::kSize).transpose();
  }

  // An anchored point moves in the world with its host, even when its own numbers stay.
  bool host_moved(std::int64_t p) const {
    return point_model(p) == PointModel::INVERSE_DEPTH && hosts_[p] >= 0 &&
           changed(hosts_[p] * kCameraStride, Pose::kSize);
  }

  Vector3 world_point(std::int64_t p) const {
    const double* block = values_.data() + points_offset_ + p * point_size_;
    switch (point_model(p)) {
      case PointModel::XYZ:
        return Eigen::Map<const Vector3>(block);
      case PointModel::HOMOGENEOUS:
        return frame_.to_world(Eigen::Map<const Vector4>(block));
      case PointModel::INVERSE_DEPTH:
        break;
    }
    const Pose host(pose(hosts_[p]));
    const Vector3 m(block[0], block[1], Camera::kViewZ);
    const double inv_depth =
        HomogeneousFrame::bounded_weight(block[2] * frame_.scale) / frame_.scale;
    return host.R_cw.transpose() * (m / inv_depth - host.t_cw);
  }

  const BundleScene& scene_;
  const PointParametrization parametrization_;
  const Constants& held_;
  HomogeneousFrame frame_;
  std::vector<std::int32_t> hosts_;
  std::int64_t point_size_ = 3;
  std::int64_t points_offset_ = 0;
  std::vector<double> values_, initial_values_, saved_values_;
};

}  // namespace raylign::ceres_backend
