// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/kernels.h"
#include "raylign/parametrization/constants.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/solver/bundle_options.h"

namespace raylign::native {

/// The cameras of a problem in the user's parametrisation, and the way from its tangent to the
/// canonical one of the kernels: [ω; δc; δ(f, k1, k2)] with R ← R Exp(ω), centre c ← c + δc. The
/// step of camera i is canonical = B_i · user (docs/theory/native-engine.md); held coordinates and
/// cameras that see nothing have no column.
class CameraBlocks {
 public:
  CameraBlocks(const BalProblem& problem,
               PoseParametrization parametrization,
               const Constants& held,
               const std::vector<bool>& observed);

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
  void write_back(BalProblem& problem) const;

 private:
  struct Camera {
    Quaternion q;   // SE3, QUATERNION
    Vector3 omega;  // ANGLE_AXIS
    Vector3 t;
    Vector3 intrinsics;
  };

  bool is_angle_axis() const { return parametrization_ == PoseParametrization::ANGLE_AXIS; }
  TranslationUpdate update() const {
    return parametrization_ == PoseParametrization::SE3 ? TranslationUpdate::COUPLED
                                                        : TranslationUpdate::ADDITIVE;
  }
  Matrix3 rotation(const Camera& camera) const;
  CameraPacket packet(const Camera& camera) const;
  int num_pose_columns(int i) const;
  Camera moved(int i, const double* delta) const;
  void move_angle_axis(int i, const double* delta, Camera& camera) const;
  void update_map(int i);

  PoseParametrization parametrization_;
  Constants held_;
  std::vector<int> offsets_;
  std::vector<Camera> initial_, cameras_, trial_;
  std::vector<CameraPacket> packets_, trial_packets_;
  std::vector<Block> maps_;
};

}  // namespace raylign::native
