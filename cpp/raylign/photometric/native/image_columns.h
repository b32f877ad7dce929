// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"

namespace raylign::native {

/// Which numbers of the images move. The kernels sum over all C numbers of every image; the free
/// columns are what is solved for: full step of image i = basis(i) · (free step at columns(i)).
/// Images that share intrinsics share their columns.
class ImageColumns {
 public:
  ImageColumns(const PatchScene& scene, const PatchConstraints& constraints);

  /// Held coordinates of a translation couple to the rotation: the basis depends on the pose.
  void set_poses(const std::vector<PatchPose>& poses);

  int num_columns() const { return num_columns_; }
  bool with_intrinsics() const { return with_intrinsics_; }
  const std::vector<int>& columns(std::int64_t image) const { return columns_[image]; }
  const Eigen::MatrixXd& basis(std::int64_t image) const { return bases_[image]; }

  /// Adds an image block (C, C) of the pair i <= k to the lower triangle of the free system.
  void add_block(std::int64_t i, std::int64_t k, const double* block, Eigen::MatrixXd& lower) const;
  void add_vector(std::int64_t i, const double* full, Eigen::VectorXd& free) const;
  void expand(const Eigen::VectorXd& free, double* full) const;  ///< (M, C)

 private:
  int C() const { return with_intrinsics_ ? 12 : 8; }

  std::vector<PoseMask> masks_;
  std::vector<std::vector<int>> columns_;
  std::vector<Eigen::MatrixXd> bases_;  // (C, f)
  int num_columns_ = 0;
  bool with_intrinsics_ = false;
};

}  // namespace raylign::native
