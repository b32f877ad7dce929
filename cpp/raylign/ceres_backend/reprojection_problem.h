// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"

namespace raylign::ceres_backend {

/// A scene as Ceres sees it: parameter blocks in the chosen parametrisation, one residual
/// block per observation, constants and gauge applied. Owns everything that the ceres::Problem
/// points to.
class ReprojectionProblem {
 public:
  /// `scene` must have finite residuals (Ceres aborts on NaN parameters) and outlive this object.
  /// Throws OptionsError for constants that the chosen parametrisation cannot hold.
  static std::unique_ptr<ReprojectionProblem> create(const BundleScene& scene,
                                                     const BundleConfig& config,
                                                     const BundleOptions& options);
  virtual ~ReprojectionProblem() = default;

  ceres::Problem& ceres_problem() { return *ceres_; }

  /// Parameter blocks in the order camera 0's pose and intrinsics, camera 1's …, points. Blocks
  /// that no observation uses are left out.
  const std::vector<double*>& blocks() const { return blocks_; }
  const std::vector<double*>& point_blocks() const { return point_blocks_; }

  /// Ceres puts the start back when it fails; what it had reached until then is kept here.
  virtual void save_state() = 0;
  virtual void restore_saved_state() = 0;
  /// Writes the current state into `scene`; blocks that still hold their first bits are left
  /// alone.
  virtual void write_back(BundleScene& scene) const = 0;

 protected:
  std::unique_ptr<ceres::Problem> ceres_;
  std::vector<double*> blocks_;
  std::vector<double*> point_blocks_;
};

}  // namespace raylign::ceres_backend
