// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <vector>

#include "raylign/ceres_backend/point_blocks.h"
#include "raylign/parametrization/constants.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/solver/bundle_options.h"

namespace raylign::ceres_backend {

/// How one point is stored in its block.
enum class PointModel { XYZ, HOMOGENEOUS, INVERSE_DEPTH };

/// Center and root-mean-square extent of the cameras; where they all stand in one place, the median
/// distance of the points; 1 when that is zero too.
HomogeneousFrame homogeneous_frame(const BalProblem& problem);

/// The numbers that Ceres moves: camera by camera pose and intrinsics, then the points, in the
/// chosen parametrisation; and the way from a BalProblem and back.
///
/// All blocks lie in one buffer, because Ceres orders the blocks of an elimination group by
/// address: with separate buffers the allocator would choose the order of the sums, and with it the
/// last bits.
template <typename Pose>
class ParameterState {
 public:
  ParameterState(const BalProblem& problem,
                 PointParametrization parametrization,
                 const Constants& held)
      : problem_(problem), parametrization_(parametrization), held_(held) {
    find_hosts();
    frame_ = homogeneous_frame(problem);
    point_size_ = parametrization == PointParametrization::HOMOGENEOUS ? 4 : 3;
    points_offset_ = problem.num_cameras() * kCameraStride;
    values_.resize(points_offset_ + problem.num_points() * point_size_);
    for (std::int64_t c = 0; c < problem.num_cameras(); ++c) load_camera(c);
    for (std::int64_t p = 0; p < problem.num_points(); ++p) load_point(p);
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

  /// Writes the state into `problem`; numbers of blocks that still hold their first bits are left
  /// alone.
  void write_back(BalProblem& problem) const {
    for (std::int64_t c = 0; c < problem.num_cameras(); ++c) write_back_camera(c, problem);
    for (std::int64_t p = 0; p < problem.num_points(); ++p) {
      if (changed(points_offset_ + p * point_size_, point_size_) || host_moved(p)) {
        problem.points.row(p) = world_point(p).transpose();
      }
    }
  }

 private:
  static constexpr std::int64_t kCameraStride = Pose::kSize + 3;

  const double* pose(std::int64_t c) const { return values_.data() + c * kCameraStride; }

  void find_hosts() {
    hosts_.assign(problem_.num_points(), -1);
    for (std::int64_t i = 0; i < problem_.num_observations(); ++i) {
      std::int32_t& host = hosts_[problem_.point_index[i]];
      const std::int32_t camera = problem_.camera_index[i];
      if (host < 0 || camera < host) host = camera;
    }
  }

  void load_camera(std::int64_t c) {
    const auto row = problem_.cameras.row(c);
    Pose::from_angle_axis(row.template head<3>().transpose(),
                          row.template segment<3>(3).transpose(), pose(c));
    Eigen::Map<Vector3>{intrinsics(c)} = row.template tail<3>().transpose();
  }

  void load_point(std::int64_t p) {
    const Vector3 x = problem_.points.row(p).transpose();
    switch (point_model(p)) {
      case PointModel::XYZ:
        Eigen::Map<Vector3>{point(p)} = x;
        return;
      case PointModel::HOMOGENEOUS:
        Eigen::Map<Vector4>{point(p)} =
            Vector3((x - frame_.center) / frame_.scale).homogeneous().stableNormalized();
        return;
      case PointModel::INVERSE_DEPTH:
        break;
    }
    if (hosts_[p] < 0) return;  // never observed: never read
    const Pose host(pose(hosts_[p]));
    const Vector3 p_h = host.R_cw * x + host.t_cw;
    Eigen::Map<Vector3>{point(p)} = Vector3(p_h.x(), p_h.y(), 1.0) / -p_h.z();
  }

  bool changed(std::int64_t offset, std::int64_t count) const {
    return std::memcmp(&values_[offset], &initial_values_[offset], count * sizeof(double)) != 0;
  }

  void write_back_camera(std::int64_t c, BalProblem& problem) const {
    const double* block = pose(c);
    const std::int64_t first = c * kCameraStride;
    constexpr std::int64_t kRotationSize = Pose::kSize - 3;
    if (changed(first, kRotationSize)) {  // a held rotation keeps the file's digits
      problem.cameras.row(c).template head<3>() = Pose::angle_axis(block).transpose();
    }
    // Translation and intrinsics are the file's own numbers: unchanged ones are copied onto
    // themselves.
    problem.cameras.row(c).template tail<6>() =
        Eigen::Map<const Vector6>(block + kRotationSize).transpose();
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
        return frame_.center +
               frame_.scale / bounded_weight(block[3]) * Eigen::Map<const Vector3>(block);
      case PointModel::INVERSE_DEPTH:
        break;
    }
    const Pose host(pose(hosts_[p]));
    const Vector3 m(block[0], block[1], -1.0);
    const double inv_depth = bounded_weight(block[2] * frame_.scale) / frame_.scale;
    return host.R_cw.transpose() * (m / inv_depth - host.t_cw);
  }

  // A BAL file has no points at infinity: they are written 1e12 camera extents away, where the
  // pixel is the same to about 1e-9 px.
  static double bounded_weight(double w) {
    constexpr double kSmallest = 1e-12;
    return std::abs(w) < kSmallest ? std::copysign(kSmallest, w) : w;
  }

  const BalProblem& problem_;
  const PointParametrization parametrization_;
  const Constants& held_;
  HomogeneousFrame frame_;
  std::vector<std::int32_t> hosts_;
  std::int64_t point_size_ = 3;
  std::int64_t points_offset_ = 0;
  std::vector<double> values_, initial_values_, saved_values_;
};

}  // namespace raylign::ceres_backend
