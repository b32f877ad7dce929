// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "raylign/patch/patch_image.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/patch/pattern.h"
#include "raylign/robust/loss.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/options.h"

namespace raylign {

/// How a patch is deformed from its host to the image that it is compared with.
enum class PatchWarp {
  AUTO,    ///< NORMAL where a normal is given or its neighbours give one, else DEPTH, else NONE
  NONE,    ///< shifted only
  DEPTH,   ///< as a surface of constant depth in the host
  NORMAL,  ///< as a plane with the point's normal
};

/// What of e^a I + b is estimated per image.
enum class BrightnessModel {
  AFFINE,  ///< a and b
  GAIN,    ///< a
  NONE,
};

/// Which images see a point.
enum class VisibilityRule {
  AUTO,    ///< candidates that pass the tests of VisibilityOptions, again in every round
  TRACKS,  ///< the problem's tracks, as far as they are inside the image
  ALL,     ///< every candidate, whether in view at the start or not
};

/// Which covariances a result has.
enum class CovarianceScope {
  NONE,
  POSES,
  ALL,  ///< of poses and of each point
};

struct BrightnessOptions {
  BrightnessModel model = BrightnessModel::AFFINE;
  double prior_sigma_a = 1.0;   ///< of a around 0, > 0
  double prior_sigma_b = 50.0;  ///< of b around 0, grey levels, > 0
  /// Residuals are scaled to one variance at every gain: noise of both images is taken into
  /// account (total least squares). Else that of the image which is multiplied pulls a towards 0.
  bool balanced = true;

  void validate() const;
};

/// The law of the residuals.
struct NoiseOptions {
  LossType loss = LossType::STUDENT_T;  ///< or TRIVIAL, HUBER, CAUCHY
  LossScope scope = LossScope::PIXEL;
  /// 0: estimated from the residuals, once per round. Else fixed, grey levels: the loss' own scale,
  /// σ for STUDENT_T and TRIVIAL, the threshold for HUBER and CAUCHY.
  double scale = 0.0;
  double nu = 0.0;            ///< degrees of freedom of STUDENT_T; 0: fitted
  double sensor_sigma = 0.0;  ///< σ of a pixel, grey levels: no estimate is smaller; >= 0

  void validate() const;
};

struct VisibilityOptions {
  VisibilityRule rule = VisibilityRule::AUTO;
  double max_view_angle = 70.0;   ///< deg between normal and ray, (0, 90]
  double max_scale_change = 4.0;  ///< s in [1 / this, this], >= 1
  double occlusion = 0.05;        ///< behind the nearest point by more than this share; 0: no test
  double max_residual = 6.0;      ///< median |r| of a patch below this many σ, > 0, or …
  double min_zncc = 0.5;          ///< … correlated at least so with what the image shows; [-1, 1]
  double min_grey = 3.0;          ///< pixels outside [min_grey, max_grey] do not count
  double max_grey = 250.0;
  double min_texture = 2.0;  ///< least standard deviation of a patch's grey values, >= 0
  int min_views = 2;         ///< views of a point, its host included, >= 1

  void validate() const;
};

/// How a photometric bundle adjustment is solved (what is held fixed: BundleConfig).
struct PhotometricOptions {
  Backend backend = Backend::NATIVE;
  PointParametrization point_parametrization = PointParametrization::XYZ;  ///< or INVERSE_DEPTH
  PatchPattern pattern = PatchPattern::square(4);
  PatchWarp warp = PatchWarp::AUTO;
  SampleInterpolation interpolation = SampleInterpolation::CUBIC_BSPLINE;
  /// σ of a Gaussian on the images, px; 0 with stored patches. Negative: by the noise of the
  /// pixels, σ: 0.3 √σ and 0.7 at most where σ is a grey level or more, else 0.
  double presmooth = 0.0;
  /// Pyramid levels; 0: as many as the expected shift needs, and where images end lost, more
  /// attempts: they are looked for by the points of the others, then all again on all levels.
  int num_levels = 0;
  BrightnessOptions brightness;
  NoiseOptions noise;
  VisibilityOptions visibility;
  bool refine_poses = true;
  bool refine_points = true;
  bool refine_intrinsics = false;
  int max_num_rounds = 6;  ///< per level, each with its own visibility, warps and law; >= 1
  int hold_out = 10;   ///< every this many points one is kept for the acceptance test; 0: no test
  bool force = false;  ///< return the refined state even when it is not accepted
  CovarianceScope covariance = CovarianceScope::POSES;
  LeavingRule leaving = LeavingRule::KEEP_COST;
  double max_leaving_share = 0.05;  ///< a step that more of the seen edges leave by is refused
  PatchBorder border = PatchBorder::REPLICATE;
  double min_depth = 1e-9;  ///< nearer points are not seen; −infinity: seen from behind too
  LmOptions lm;
  /// λI instead of λ diag(H), the first λ being lm.initial_lambda times the largest entry of
  /// diag(H): the original exercise.
  bool additive_damping = false;

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

std::string to_string(PatchWarp value);
std::string to_string(BrightnessModel value);
std::string to_string(VisibilityRule value);
std::string to_string(CovarianceScope value);

}  // namespace raylign
