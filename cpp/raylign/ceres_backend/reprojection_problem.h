// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "raylign/ceres_backend/ceres_problem.h"
#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"

namespace raylign::ceres_backend {

/// A scene as Ceres sees it: parameter blocks in the chosen parametrisation, one residual
/// block per observation, constants and gauge applied. Owns everything that the ceres::Problem
/// points to.
class ReprojectionProblem : public CeresProblem {
 public:
  /// `scene` must have finite residuals (Ceres aborts on NaN parameters) and outlive this object.
  /// Throws OptionsError for constants that the chosen parametrisation cannot hold.
  static std::unique_ptr<ReprojectionProblem> create(const BundleScene& scene,
                                                     const BundleConfig& config,
                                                     const BundleOptions& options);

  /// Writes the current state into `scene`; blocks that still hold their first bits are left
  /// alone.
  virtual void write_back(BundleScene& scene) const = 0;
};

}  // namespace raylign::ceres_backend
