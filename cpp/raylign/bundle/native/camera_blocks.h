// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/kernels.h"
#include "raylign/parametrization/constants.h"
#include "raylign/parametrization/homogeneous.h"
#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_options.h"

namespace raylign::native {

/// The cameras of a problem in the user's parametrisation, and the way from its tangent to the
/// canonical one of the kernels: [ω; δc; δi] with R ← R Exp(ω), centre c ← c + δc
/// and i the intrinsics that may move, at most three (of BAL: f, k1, k2, held or not). The
/// step of camera i is canonical = B_i · user (docs/theory/native-engine.md); held coordinates and
/// cameras that see nothing have no column. Packets and δc are in the coordinates of `frame`:
/// centre (c − center) / scale, translation likewise; the points must be, too.
class CameraBlocks {
 public:
  CameraBlocks(const BundleScene& scene,
               PoseParametrization parametrization,
               const Constants& held,
               const std::vector<bool>& observed,
               const HomogeneousFrame& frame = {});

  int num_cameras() const { return static_cast<int>(cameras_.size()); }
  int num_columns() const { return offsets_.back(); }
  int offset(int i) const { return offsets_[i]; }  ///< first column of camera i
  int size(int i) const { return offsets_[i + 1] - offsets_[i]; }

  /// B_i: nine rows of kRow, size(i) columns used, zeros beyond.
  const Block& map(int i) const { return maps_[i]; }
  const CameraPacket* packets() const { return packets_.data(); }
  const CameraPacket* trial_packets() const { return trial_packets_.data(); }

  /// Puts the cameras moved by `delta` (num_columns(),) beside the current ones.
  void try_step(const double* delta);
  /// The moved cameras become the current ones.
  void accept();

  /// Squared norm of the numbers of every block that may move.
  double squared_norm() const;
  /// Numbers that did not move keep their bits.
  void write_back(BundleScene& scene) const;

 private:
  using IntrinsicsVector = Eigen::Matrix<double, kMaxCameraParams, 1>;
  struct Camera {
    Quaternion q;   // SE3, QUATERNION
    Vector3 omega;  // ANGLE_AXIS
    Vector3 t;
    IntrinsicsVector intrinsics;
  };

  bool is_angle_axis() const { return parametrization_ == PoseParametrization::ANGLE_AXIS; }
  TranslationUpdate update() const {
    return parametrization_ == PoseParametrization::SE3 ? TranslationUpdate::COUPLED
                                                        : TranslationUpdate::ADDITIVE;
  }
  Matrix3 rotation(const Camera& camera) const;
  CameraPacket packet(int i, const Camera& camera) const;
  void set_columns(int i, std::int32_t* columns) const;
  int num_pose_columns(int i) const;
  Camera moved(int i, const double* delta) const;
  void move_angle_axis(int i, const double* delta, Camera& camera) const;
  void update_map(int i);

  CameraModel model_;
  int num_intrinsics_;
  PoseParametrization parametrization_;
  HomogeneousFrame frame_;
  Constants held_;
  std::vector<int> offsets_;
  std::vector<Camera> initial_, cameras_, trial_;
  std::vector<CameraPacket> packets_, trial_packets_;
  std::vector<Block> maps_;
};

}  // namespace raylign::native
