// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/parametrization/pose_update.h"
#include "raylign/robust/loss.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/lm.h"
#include "raylign/solver/options.h"

namespace raylign {

/// What the robust law sees.
enum class LossScope {
  PIXEL,  ///< each r_n by itself
  PATCH,  ///< ‖r‖² of all pixels of an edge together
};

/// What an edge costs that leaves its image.
enum class LeavingRule {
  KEEP_COST,  ///< what it cost at the start of the solve, so that leaving is no gain
  ZERO,       ///< nothing: the original exercise
};

/// A Gaussian prior on a pose: ½ ξᵀ Λ ξ, ξ = log(T_cw T_prior⁻¹).
struct PosePrior {
  std::int32_t image = 0;
  Matrix4 T_cw = Matrix4::Identity();
  Matrix6 information = Matrix6::Zero();  ///< in units of the cost: grey² per unit of ξ²
};

/// ½ (X − X₀)ᵀ Λ (X − X₀); inverse depth: the first coordinate alone, ρ and Λ_00.
struct PatchPointPrior {
  std::int64_t point = 0;
  Vector3 value = Vector3::Zero();
  Matrix3 information = Matrix3::Zero();
};

/// What a solve of a PatchScene holds fixed or near a value.
struct PatchConstraints {
  std::vector<PoseMask> poses;                  ///< (M,)
  std::vector<std::array<bool, 2>> brightness;  ///< (M,) whether a, b are held
  std::vector<std::array<bool, 4>> intrinsics;  ///< (1,) or (M,), as PatchScene::intrinsics
  std::vector<bool> points;                     ///< (N,) whether a point is held, or empty: none
  /// Weights of ½ (a² / σ_a² + b² / σ_b²) of each image whose a, b are free; 0: no prior.
  double weight_a = 0.0;
  double weight_b = 0.0;
  std::vector<PosePrior> pose_priors;
  std::vector<PatchPointPrior> point_priors;
};

/// How a PatchScene is solved once everything else is decided.
struct PatchSolveOptions {
  Loss loss;  ///< TRIVIAL, HUBER, CAUCHY or STUDENT_T; scale in grey levels
  LossScope scope = LossScope::PIXEL;
  LeavingRule leaving = LeavingRule::KEEP_COST;
  double max_leaving_share = 0.05;  ///< a step that more of the seen edges leave by is refused
  LmOptions lm;
  LambdaRule lambda_rule = LambdaRule::CERES;  ///< NATIVE only

  /// Throws OptionsError.
  void validate() const;
};

struct PatchScene;

/// What every solve asks of its input before anything else: the scene fits itself, the constraints
/// fit the scene. Throws ShapeError, OptionsError.
void validate_patch_solve(const PatchScene& scene,
                          const PatchConstraints& constraints,
                          const PatchSolveOptions& options);

}  // namespace raylign
