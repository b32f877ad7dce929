// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "raylign/robust/loss.h"
#include "raylign/solver/options.h"

namespace raylign {

/// Intensity noise of the residual, eq. 14 of LSD-SLAM.
enum class NoiseModel {
  CONSTANT,  ///< 2 σ_I² on every level, the paper's: interpolation counts as a second full noise
  EXACT,     ///< what bilinear interpolation and the pyramid's averaging leave of σ_I²
};

/// When σ_r of a point is computed.
enum class SigmaMode {
  REEVALUATE,  ///< at each accepted pose, as the paper; a trial is compared at the σ before it
  FROZEN,      ///< once per level, at its start: one cost per level
};

/// Whose image gradient stands in the Jacobian.
enum class GradientMode {
  FORWARD,  ///< the target's, at the warped point
  ESM,      ///< the mean of that and the keyframe's, turned by the roll between them
};

/// How the target's brightness e^a I + b is found.
enum class AffineMode {
  NONE,
  CLOSED_FORM,  ///< by weighted regression between the steps, symmetric in both images
  JOINT,        ///< two more columns of the normal equations, with priors
};

/// What moves.
enum class MotionGroup {
  SE3,
  SO3,   ///< rotation about the target's own centre
  SIM3,  ///< needs the depth residual: intensities do not see scale
};

struct AffineOptions {
  AffineMode mode = AffineMode::JOINT;
  /// Prior of JOINT, as if each point were a measurement of a = 0 and of b = 0 with these standard
  /// deviations (grey levels per σ_I² are what a point measures itself); > 0.
  double prior_sigma_a = 1.0;
  double prior_sigma_b = 10.0;  ///< grey levels

  void validate() const;
};

/// The depth residual 1/Z' − D_t(p'), used when the target frame has depth.
struct DepthTermOptions {
  bool enabled = true;
  bool estimate_weight = true;  ///< from the terms' own residuals, level by level; see below
  /// Factor of the depth term's cost, times the estimated one; >= 0. More than 1 because an error
  /// that a whole image shares, of calibration or registration, weighs on intensities and is not
  /// seen in blocks: 5 to 30 give the lowest drift on TUM fr1/xyz and 7-Scenes alike.
  double weight = 10.0;
  bool use_gradient = true;  ///< ∇D_t in the derivatives
  /// |1/Z' − D_t| beyond this share of D_t: the target shows another surface there, something has
  /// come between; no residual. > 0. Not for SIM3, which has another scale to find.
  double max_difference = 0.1;

  void validate() const;
};

/// When a result is not OK. A ratio is one of reference points, never of pixels.
struct AcceptanceOptions {
  int min_points = 50;          ///< reference points on the finest level, >= 1
  double min_overlap = 0.3;     ///< share of them within the target's view, in [0, 1]
  double min_good_ratio = 0.5;  ///< share of those in view with r² < 40² + |∇I|²/4, in [0, 1]
  double min_agreement = 0.15;  ///< AlignmentResult::agreement, in [0, 1]
  /// Bounds of the motion from keyframe to target: translation as a share of the mean depth, and
  /// rotation in rad; > 0.
  double max_translation = 1.0;
  double max_rotation = 1.0;
  /// A direction of the pose counts as undetermined when its standard deviation is larger:
  /// translation as a share of the mean depth, rotation in rad; > 0.
  double max_sigma = 0.02;

  void validate() const;
};

/// How a frame is aligned with a keyframe.
struct TrackingOptions {
  MotionGroup motion = MotionGroup::SE3;
  NoiseModel noise_model = NoiseModel::CONSTANT;
  /// σ_I, grey levels, > 0. √8: 2 σ_I² = 16, the value of LSD-SLAM's program.
  double sigma_intensity = 2.8284271247461903;
  /// Where the finest level's residuals turn out much smaller than σ_r, it is scaled to them, as
  /// far as σ_I = min_sigma_intensity, and the level aligned on: an outlier is then known for one.
  bool adapt_sigma = true;
  double min_sigma_intensity = 0.3;  ///< grey levels, > 0: rounding to integers
  SigmaMode sigma_mode = SigmaMode::REEVALUATE;
  Loss loss = {LossType::HUBER, 1.5, 5.0};  ///< of r / σ_r, scale without unit
  GradientMode gradient = GradientMode::FORWARD;
  AffineOptions affine;
  DepthTermOptions depth;
  int finest_level = 1;    ///< >= 0; a shallower pyramid: its last level
  int coarsest_level = 4;  ///< >= finest_level
  /// Before the first level, turns the start about the target's centre by intensities alone: what
  /// a rotation explains is not first taken for a translation, and the basin is wider.
  bool rotation_first = true;
  /// Iterations on level l at most: level_iterations[l], lm.max_num_iterations where there is none.
  std::vector<int> level_iterations;
  LmOptions lm = default_lm();
  AcceptanceOptions acceptance;

  static LmOptions default_lm();
  int max_iterations(int level) const;
  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// Which pixels of a keyframe become points. On every level by itself.
struct KeyframeOptions {
  double min_gradient = 4.0;  ///< |∇I| of a point at least, grey levels per px of its level; >= 0
  int max_points = 0;  ///< budget per level, evenly over the image, strongest first; 0: no limit
  int spacing = 1;     ///< px: only pixels of a grid this wide; >= 1
  /// Side of the blocks whose points are taken as correlated by the covariance, px of levels 0 and
  /// 1, half of it on coarser ones; an even number in [4, 256].
  int block_size = 16;

  void validate() const;
};

std::string to_string(NoiseModel value);
std::string to_string(SigmaMode value);
std::string to_string(GradientMode value);
std::string to_string(AffineMode value);
std::string to_string(MotionGroup value);

}  // namespace raylign
