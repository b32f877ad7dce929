// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/image/plane.h"
#include "raylign/solver/summary.h"
#include "raylign/tracking/options.h"
#include "raylign/tracking/shutter.h"

namespace raylign {

/// Whether a result may be used, and if not, why.
enum class AlignmentStatus {
  OK,
  LOST_OVERLAP,    ///< too few points of the keyframe are in the target's view
  TOO_FEW_POINTS,  ///< the keyframe has too few points with depth
  DIVERGED,        ///< the images do not agree at the pose found
  NOT_CONVERGED,   ///< the iterations were spent before the steps became small
  DEGENERATE,      ///< a direction of the pose is not determined
  LOW_TEXTURE,     ///< the keyframe has depth but too little gradient
  MOTION_BOUND,    ///< the pose found is farther away than acceptance allows
};

std::string to_string(AlignmentStatus status);

/// One level, coarse to fine.
struct LevelResult {
  int level = -1;
  int num_points = 0;
  int num_evaluations = 0;    ///< passes over the points
  double depth_weight = 0.0;  ///< of the depth term's cost against the photometric one's
  Summary summary;            ///< of the Levenberg-Marquardt loop
};

/// Per pixel of the finest level tracked on; NaN where there is no point, or no residual.
struct AlignmentMaps {
  Plane<float> residual;             ///< r, grey levels
  Plane<float> sigma;                ///< σ_r, grey levels
  Plane<float> normalised_residual;  ///< r / σ_r
  Plane<float> weight;               ///< ρ′ of r / σ_r
  Plane<float> warped;               ///< e^a I_t(p') + b, wherever the keyframe has depth
  Plane<unsigned char> mask;         ///< 1: a point with a residual
};

/// What `align` found. Impossible values until it is filled.
struct AlignmentResult {
  MotionGroup motion = MotionGroup::SE3;
  Matrix4 T_th = Matrix4::Identity();  ///< keyframe to target; scaled rotation for SIM3
  AlignmentStatus status = AlignmentStatus::TOO_FEW_POINTS;
  std::string reason = "nothing was aligned";
  /// JᵀWJ of ξ = [υ; ω; σ], the left perturbation T_th ← exp(ξ) T_th, brightness marginalised;
  /// zero rows and columns where the motion has no such coordinate.
  Matrix7 information = Matrix7::Zero();
  /// Inverse of `information`: true when residuals are independent and σ_r is right.
  Matrix7 hessian_covariance = Matrix7::Constant(std::numeric_limits<double>::quiet_NaN());
  /// Block-wise sandwich: calibrated for residuals that are correlated within blocks.
  Matrix7 covariance = Matrix7::Constant(std::numeric_limits<double>::quiet_NaN());
  /// Ascending, with translation in units of the mean depth: without unit. As many as the motion
  /// has coordinates.
  std::vector<double> information_eigenvalues;
  Vector7 weakest_direction = Vector7::Zero();  ///< eigenvector of the first
  /// Mean ratio of `covariance` to `hessian_covariance`, −1 where there is no block-wise one.
  double inflation = -1.0;
  double sigma_scale = 1.0;         ///< by which σ_r was scaled, TrackingOptions::adapt_sigma
  double residual_variance = -1.0;  ///< Σ ρ′ n² / Σ ρ′: 1 when σ_r is right
  double depth_residual_variance = -1.0;
  int num_points = 0;       ///< reference points of the finest level
  double overlap = 0.0;     ///< share of them in view
  double usage = 0.0;       ///< the same, points that recede counting less
  double good_ratio = 0.0;  ///< share of those in view with r² < 40² + |∇I|²/4
  /// Share of points that agree within 3 σ_r beyond what a wrong pose scores by chance: 1 all, 0
  /// none.
  double agreement = 0.0;
  double a = 0.0;  ///< target brightness: r = I_h − (e^a I_t + b)
  double b = 0.0;  ///< grey levels
  double mean_inverse_depth = 0.0;
  ReadoutEquation readout;          ///< where AlignmentStart::shutter has a motion
  std::vector<LevelResult> levels;  ///< coarse to fine
  AlignmentMaps maps;               ///< empty unless asked for
};

}  // namespace raylign
