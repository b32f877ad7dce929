// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "raylign/geometry/se3.h"
#include "raylign/geometry/sim3.h"
#include "raylign/solver/lm.h"
#include "raylign/tracking/point_pass.h"

namespace raylign::tracking {

/// Everything that a pass can move: [υ; ω; σ; a; b].
inline constexpr int kColumns = 9;
inline constexpr int kColumnA = 7;
inline constexpr int kColumnB = 8;
using Vector9 = Eigen::Matrix<double, kColumns, 1>;
using Matrix9 = Eigen::Matrix<double, kColumns, kColumns>;

/// The motions: which coordinates of [υ; ω; σ] are free, and how they move T_th.
struct Se3Motion {
  static constexpr int kFirst = 0;
  static constexpr int kSize = 6;
  static Matrix4 exp(const Vector7& xi) { return se3_exp(xi.head<6>()); }
};

struct So3Motion {
  static constexpr int kFirst = 3;
  static constexpr int kSize = 3;
  static Matrix4 exp(const Vector7& xi) { return se3_exp(xi.head<6>()); }
};

struct Sim3Motion {
  static constexpr int kFirst = 0;
  static constexpr int kSize = 7;
  static Matrix4 exp(const Vector7& xi) { return sim3_exp(xi); }
};

/// H = JᵀWJ and g = JᵀWr of both terms, over all nine columns.
struct NormalEquations {
  Matrix9 H = Matrix9::Zero();
  Vector9 g = Vector9::Zero();
};

NormalEquations photometric_equations(const TermSums& sums, bool with_brightness);
NormalEquations depth_equations(const TermSums& sums, bool with_scale);
/// The gradient of one tile.
Vector9 tile_gradient(const TileSums& tile, double depth_weight, bool with_scale);

/// The brightness (a, b) that gives the target the keyframe's weighted mean and standard deviation,
/// from the sums of a pass at `state`: symmetric in both images, not shrunk by noise as a
/// least-squares slope would be. `state` itself when the sums say nothing.
PoseState closed_form_brightness(const TermSums& sums, const PoseState& state);

/// Alignment on one level as the Levenberg-Marquardt loop sees it (solver/lm.h). One pass over the
/// points gives a trial's cost and, should it be accepted, its normal equations.
///
/// Cost = ½ Σ ρ(n²) over all reference points. A point without a residual (out of view, no depth
/// there) counts as much as the mean point in view does at the current state: for the trial that is
/// judged, leaving the image is neither a gain nor a loss. σ is that of the current state, too.
template <typename Motion>
class AlignmentProblem {
 public:
  AlignmentProblem(PointPass& pass,
                   const TrackingOptions& options,
                   const PoseState& start,
                   const TermScales& scales,
                   bool with_tiles = false)
      : pass_(pass),
        options_(options),
        scales_(scales),
        with_tiles_(with_tiles),
        state_(start),
        num_points_(pass.num_points()) {
    for (int k = 0; k < Motion::kSize; ++k) columns_.push_back(Motion::kFirst + k);
    if (options_.affine.mode == AffineMode::JOINT) {
      columns_.push_back(kColumnA);
      columns_.push_back(kColumnB);
    }
  }

  LmState linearize() {
    if (num_evaluations_ == 0) sums_ = run(state_, nullptr, buffers(current_));
    if (options_.affine.mode == AffineMode::CLOSED_FORM) update_brightness();
    outside_photometric_ = mean_rho(sums_.photometric);
    outside_depth_ = mean_rho(sums_.depth);
    set_equations();
    if (column_scales_.empty()) {
      for (const int k : columns_) {
        column_scales_.push_back(lm_column_scale(equations_.H(k, k), options_.lm));
      }
    }
    double max_norm = 0.0;
    for (const int k : columns_) {
      max_norm =
          std::isfinite(equations_.g[k]) ? std::max(max_norm, std::abs(equations_.g[k])) : NAN;
      if (std::isnan(max_norm)) break;
    }
    return {cost(sums_, false, state_), max_norm};
  }

  LmSolve solve(double lambda, bool /*tight*/ = false) {  // always exact
    const auto n = static_cast<int>(columns_.size());
    System A(n, n);
    Step rhs(n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) A(i, j) = equations_.H(columns_[i], columns_[j]);
      A(i, i) += lambda * lm_damping(A(i, i), column_scales_[i], options_.lm);
      rhs[i] = -equations_.g[columns_[i]];
    }
    const Step step = A.ldlt().solve(rhs);
    step_.setZero();
    for (int i = 0; i < n; ++i) step_[columns_[i]] = step[i];
    LmSolve result;
    result.solved = step_.allFinite();
    return result;
  }

  LmTrial try_step() {
    trial_ = state_;
    trial_.T_th = Motion::exp(step_.head<7>()) * state_.T_th;
    trial_.a += step_[kColumnA];
    trial_.b += step_[kColumnB];
    trial_sums_ = run(trial_, &buffers(current_), buffers(1 - current_));
    const double model = -equations_.g.dot(step_) - 0.5 * step_.dot(equations_.H * step_);
    return {cost(trial_sums_, true, trial_), model, step_norm(), 1.0};
  }

  void accept() {
    state_ = trial_;
    sums_ = trial_sums_;
    current_ = 1 - current_;
  }

  const PoseState& state() const { return state_; }
  const PassSums& sums() const { return sums_; }
  int num_evaluations() const { return num_evaluations_; }
  /// By tiles, at the current state.
  const std::vector<TileSums>& tiles() const { return pass_.workspace().buffers[current_].tiles; }
  /// By bands, at the current state.
  const std::vector<PassSums>& bands() const { return pass_.workspace().buffers[current_].bands; }

  /// Takes σ_r times `scale` from now on, at the current state.
  void set_photometric_scale(double scale) {
    scales_.photometric_scale = scale;
    column_scales_.clear();
    sums_ = run(state_, nullptr, buffers(current_));
  }
  const TermScales& scales() const { return scales_; }

  /// Makes the sums those of σ at the current state.
  void thaw() {
    if (options_.sigma_mode != SigmaMode::FROZEN) return;
    sums_ = run(state_, nullptr, buffers(current_));
  }

 private:
  using System = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kColumns, kColumns>;
  using Step = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kColumns, 1>;
  // a change of brightness that no pass is spent on
  static constexpr double kSmallA = 1e-3;
  static constexpr double kSmallB = 0.1;
  static constexpr double kGreyRange = 255.0;

  PassBuffers& buffers(int i) { return pass_.workspace().buffers[i]; }

  PassSums run(const PoseState& state, const PassBuffers* reference, PassBuffers& out) {
    ++num_evaluations_;
    return pass_.run(state, scales_, reference, out, with_tiles_);
  }

  static double mean_rho(const TermSums& sums) {
    return sums.count > 0.0 ? sums.rho / sums.count : 0.0;
  }

  void update_brightness() {
    const PoseState better = closed_form_brightness(sums_.photometric, state_);
    if (std::abs(better.a - state_.a) < kSmallA && std::abs(better.b - state_.b) < kSmallB) return;
    state_ = better;
    const bool freeze = options_.sigma_mode == SigmaMode::FROZEN;
    sums_ = run(state_, freeze ? &buffers(current_) : nullptr, buffers(1 - current_));
    current_ = 1 - current_;
  }

  void set_equations() {
    const bool brightness = options_.affine.mode != AffineMode::NONE;
    const bool scale = options_.motion == MotionGroup::SIM3;
    equations_ = photometric_equations(sums_.photometric, brightness);
    if (pass_.has_depth_term()) {
      const NormalEquations depth = depth_equations(sums_.depth, scale);
      equations_.H += scales_.depth_weight * depth.H;
      equations_.g += scales_.depth_weight * depth.g;
    }
    if (options_.affine.mode != AffineMode::JOINT) return;
    equations_.H(kColumnA, kColumnA) += prior_a();
    equations_.H(kColumnB, kColumnB) += prior_b();
    equations_.g[kColumnA] += prior_a() * state_.a;
    equations_.g[kColumnB] += prior_b() * state_.b;
  }

  double prior_a() const {
    return num_points_ / (options_.affine.prior_sigma_a * options_.affine.prior_sigma_a);
  }
  double prior_b() const {
    return num_points_ / (options_.affine.prior_sigma_b * options_.affine.prior_sigma_b);
  }

  double cost(const PassSums& sums, bool at_reference, const PoseState& state) const {
    const auto of_term = [&](const TermSums& term, double outside) {
      return (at_reference ? term.rho_reference : term.rho) + (num_points_ - term.count) * outside;
    };
    double twice = of_term(sums.photometric, outside_photometric_);
    if (pass_.has_depth_term()) {
      twice += scales_.depth_weight * of_term(sums.depth, outside_depth_);
    }
    if (options_.affine.mode == AffineMode::JOINT) {
      twice += prior_a() * state.a * state.a + prior_b() * state.b * state.b;
    }
    return 0.5 * twice;
  }

  // Without unit: translation as a share of the mean depth.
  double step_norm() const {
    const double D = pass_.mean_inverse_depth();
    const double b = step_[kColumnB] / kGreyRange;
    return std::sqrt(D * D * step_.head<3>().squaredNorm() + step_.segment<5>(3).squaredNorm() +
                     b * b);
  }

  PointPass& pass_;
  const TrackingOptions& options_;
  TermScales scales_;
  bool with_tiles_;
  PoseState state_, trial_;
  PassSums sums_, trial_sums_;
  NormalEquations equations_;
  Vector9 step_ = Vector9::Zero();
  std::vector<int> columns_;
  std::vector<double> column_scales_;
  double num_points_;
  double outside_photometric_ = 0.0;
  double outside_depth_ = 0.0;
  int current_ = 0;
  int num_evaluations_ = 0;
};

}  // namespace raylign::tracking
