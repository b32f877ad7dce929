// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "raylign/base/error.h"
#include "raylign/base/stopwatch.h"
#include "raylign/solver/options.h"
#include "raylign/solver/summary.h"

namespace raylign {

/// What a problem says about its current state.
struct LmState {
  double cost = -1.0;
  double gradient_max_norm = -1.0;  ///< max |Jᵀr|
};

/// What a problem says about the linear system it has just solved.
struct LmSolve {
  bool solved = false;       ///< there is a finite step
  int iterations = 1;        ///< of an iterative solver; 1 for a factorisation
  bool interrupted = false;  ///< not solved because the problem was told to stop
  bool inexact = false;      ///< a closer solution was to be had: a small step proves nothing
};

/// What a problem says about the step it has just tried.
struct LmTrial {
  double cost = -1.0;            ///< at the trial state; not finite: the step is invalid
  double model_decrease = -1.0;  ///< −gᵀδ − ½‖Jδ‖², of the actual δ, without damping
  double step_norm = 0.0;        ///< ‖δ‖
  double state_norm = 0.0;       ///< ‖x‖, before the step
};

/// Column j of J is damped by λ · lm_damping(‖column j‖², s_j): Ceres' rule, clamp(diag(JᵀJ)) on
/// the Jacobi-scaled columns, written without scaling anything.
inline double lm_damping(double squared_column_norm, double scale, const LmOptions& options) {
  const double s2 = scale * scale;
  return std::clamp(s2 * squared_column_norm, options.min_diagonal, options.max_diagonal) / s2;
}

/// s_j = 1 / (1 + ‖column j‖) at the start of a solve, or 1 without Jacobi scaling.
inline double lm_column_scale(double squared_column_norm, const LmOptions& options) {
  return options.jacobi_scaling ? 1.0 / (1.0 + std::sqrt(squared_column_norm)) : 1.0;
}

/// How far λ falls after an accepted step of gain ratio ρ.
enum class LambdaRule {
  CERES,  ///< λ · max(1/3, 1 − (2ρ − 1)³): Nielsen 1999
  FAST,   ///< the same, but λ / 10 where the model kept its promise, ρ > 0.8
  G2O,    ///< the first, but at most 2/3 λ: every accepted step lowers it
};

/// The Levenberg-Marquardt loop with the trust-region rules and constants of Ceres (Nielsen 1999;
/// Madsen, Nielsen, Tingleff 2004, §3.2), λ = 1 / radius. `Problem` is any class with
///
///   LmState linearize();          // at the current state; called at the start and after `accept`
///   LmSolve solve(double lambda, bool tight);  // a step for this damping; tight: an exact one
///   LmTrial try_step();           // current state plus step, kept beside the current state
///   void accept();                // the trial state becomes the current one
///
/// and whose current state is the best one found, at every moment: an exception from the callback
/// may leave the loop between any two of these calls.
template <typename Problem>
class LmLoop {
 public:
  /// @param clock                started when the user's call began: limits and times count from it
  /// @param num_residual_blocks  copied into each row
  LmLoop(Problem& problem,
         const LmOptions& options,
         const IterationCallback& callback,
         const Stopwatch& clock,
         int num_residual_blocks,
         LambdaRule lambda_rule)
      : problem_(problem),
        options_(options),
        callback_(callback),
        clock_(clock),
        num_residual_blocks_(num_residual_blocks),
        lambda_rule_(lambda_rule),
        lambda_(options.initial_lambda) {}

  /// Fills termination, message, costs, step counts, iterations and the times of the stages; the
  /// rest of the summary is the caller's.
  Summary run() {
    start();
    while (record_and_go_on()) iterate();
    summary_.final_cost = state_.cost;
    summary_.count_steps();
    return summary_;
  }

 private:
  static constexpr double kShrinkLimit = 1.0 / 3.0;
  static constexpr double kWeakestShrink = 2.0 / 3.0;
  static constexpr double kGoodGain = 0.8;
  static constexpr double kFastShrink = 0.1;
  static constexpr int kMaxReservedRows = 1000;
  static constexpr const char* kTimeLimit = "max_solver_time_s reached";

  void start() {
    summary_.iterations.reserve(std::min(options_.max_num_iterations, kMaxReservedRows) + 1);
    begin_row(0);
    linearize();
    summary_.initial_cost = state_.cost;
    if (std::isfinite(state_.cost) && std::isfinite(state_.gradient_max_norm)) return;
    finish(Termination::FAILURE, "the start has no finite cost or gradient");
  }

  void iterate() {
    begin_row(row_.iteration + 1);
    const LmSolve step = solve();
    if (step.interrupted) return stop_inside();
    const LmTrial trial = step.solved ? try_step() : LmTrial{};
    row_.step_is_valid = step.solved && std::isfinite(trial.cost) && trial.model_decrease > 0.0;
    if (!row_.step_is_valid) return reject_invalid_step();
    num_consecutive_invalid_ = 0;
    row_.cost_change = state_.cost - trial.cost;
    row_.gain_ratio = row_.cost_change / trial.model_decrease;
    row_.step_norm = trial.step_norm;
    if (step.inexact && (step_is_small(trial) || cost_change_is_small(trial))) {
      is_tight_ = true;  // from here on: convergence is for exact steps to find
    } else if (step_is_small(trial)) {
      finish(Termination::CONVERGENCE, "Parameter tolerance reached. ‖δ‖ / (‖x‖ + tolerance): " +
                                           format_double(trial.step_norm / trial.state_norm));
    } else if (cost_change_is_small(trial)) {
      finish(Termination::CONVERGENCE, "Function tolerance reached. |cost change| / cost: " +
                                           format_double(std::abs(row_.cost_change) / state_.cost));
    }
    if (finished_) return adopt_last_step();
    if (row_.gain_ratio > options_.min_relative_decrease) return accept();
    row_.cost_change = 0.0;
    raise_lambda();
  }

  void begin_row(int iteration) {
    row_ = IterationSummary();
    row_.iteration = iteration;
    row_.num_residual_blocks = num_residual_blocks_;
    row_start_s_ = clock_.seconds();
  }

  void linearize() {
    const Stopwatch watch;
    state_ = problem_.linearize();
    summary_.jacobian_time_s += watch.seconds();
  }

  LmSolve solve() {
    const Stopwatch watch;
    const LmSolve step = problem_.solve(lambda_, is_tight_);
    row_.linear_solver_iterations = step.iterations;
    row_.linear_solver_time_s = watch.seconds();
    summary_.linear_solver_time_s += row_.linear_solver_time_s;
    return step;
  }

  void stop_inside() {
    if (clock_.seconds() >= options_.max_solver_time_s) {
      finish(Termination::TIME_LIMIT, kTimeLimit);
    } else {
      finish(Termination::USER_STOPPED, "interrupted inside the linear solver");
    }
  }

  LmTrial try_step() {
    const Stopwatch watch;
    const LmTrial trial = problem_.try_step();
    summary_.residual_time_s += watch.seconds();
    return trial;
  }

  void accept() {
    problem_.accept();
    row_.step_is_accepted = true;
    had_accepted_step_ = true;
    linearize();
    lower_lambda();
    if (!std::isfinite(state_.gradient_max_norm)) {
      finish(Termination::FAILURE, "the gradient is not finite after a step");
    }
  }

  // The step that met a tolerance is taken when it gains; Ceres throws it away.
  void adopt_last_step() {
    if (!(row_.cost_change > 0.0)) {
      row_.cost_change = 0.0;
      return;
    }
    problem_.accept();
    row_.step_is_accepted = true;
    state_.cost -= row_.cost_change;
  }

  void reject_invalid_step() {
    raise_lambda();
    if (++num_consecutive_invalid_ < options_.max_num_consecutive_invalid_steps) return;
    finish(Termination::FAILURE, std::to_string(num_consecutive_invalid_) +
                                     " consecutive steps had no finite cost or no decrease of the "
                                     "model (max_num_consecutive_invalid_steps)");
  }

  void lower_lambda() {
    const double q = 2.0 * row_.gain_ratio - 1.0;
    double factor = std::max(kShrinkLimit, 1.0 - q * q * q);
    if (lambda_rule_ == LambdaRule::FAST && row_.gain_ratio > kGoodGain) factor = kFastShrink;
    if (lambda_rule_ == LambdaRule::G2O) factor = std::min(factor, kWeakestShrink);
    lambda_ = std::max(options_.min_lambda, lambda_ * factor);
    growth_ = 2.0;
  }

  void raise_lambda() {
    lambda_ *= growth_;
    growth_ *= 2.0;
  }

  bool step_is_small(const LmTrial& trial) const {
    const double tolerance = options_.parameter_tolerance;
    return had_accepted_step_ && trial.step_norm <= tolerance * (trial.state_norm + tolerance);
  }

  // Under FAST a step that gains nothing where the model promises something says that λ is too low;
  // Ceres takes it for the minimum when the cost happens to be nearly the same.
  bool cost_change_is_small(const LmTrial& trial) const {
    const double small = options_.function_tolerance * state_.cost;
    if (!(std::abs(row_.cost_change) <= small)) return false;
    return lambda_rule_ != LambdaRule::FAST || trial.model_decrease <= small ||
           row_.gain_ratio > options_.min_relative_decrease;
  }

  // Closes the row, asks the callback, then the limits, in Ceres' order.
  bool record_and_go_on() {
    row_.cost = state_.cost;
    row_.gradient_max_norm = state_.gradient_max_norm;
    row_.lambda = lambda_;
    row_.cumulative_time_s = clock_.seconds();
    row_.iteration_time_s = row_.cumulative_time_s - row_start_s_;
    summary_.iterations.push_back(row_);
    const bool stop = callback_ && callback_(row_) == CallbackAction::STOP;
    if (finished_) return false;
    if (stop) {
      finish(Termination::USER_STOPPED, "the callback asked to stop");
    } else if (row_.cumulative_time_s >= options_.max_solver_time_s) {
      finish(Termination::TIME_LIMIT, kTimeLimit);
    } else if (row_.iteration >= options_.max_num_iterations) {
      finish(Termination::MAX_ITERATIONS, "max_num_iterations reached");
    } else if (state_.gradient_max_norm <= options_.gradient_tolerance) {
      finish(Termination::CONVERGENCE, "Gradient tolerance reached. Gradient max norm: " +
                                           format_double(state_.gradient_max_norm));
    } else if (lambda_ >= options_.max_lambda) {
      finish(Termination::CONVERGENCE, "max_lambda reached: no step lowers the cost");
    }
    return !finished_;
  }

  void finish(Termination termination, const std::string& message) {
    finished_ = true;
    summary_.termination = termination;
    summary_.message = message;
  }

  Problem& problem_;
  const LmOptions& options_;
  const IterationCallback& callback_;
  const Stopwatch& clock_;
  const int num_residual_blocks_;
  const LambdaRule lambda_rule_;
  double lambda_;
  double growth_ = 2.0;  // ν of Nielsen's rule
  int num_consecutive_invalid_ = 0;
  bool had_accepted_step_ = false;
  bool finished_ = false;
  bool is_tight_ = false;
  LmState state_;
  IterationSummary row_;
  double row_start_s_ = 0.0;
  Summary summary_;
};

/// Minimises; see LmLoop.
template <typename Problem>
Summary minimize(Problem& problem,
                 const LmOptions& options,
                 const IterationCallback& callback,
                 const Stopwatch& clock,
                 int num_residual_blocks,
                 LambdaRule lambda_rule = LambdaRule::CERES) {
  return LmLoop<Problem>(problem, options, callback, clock, num_residual_blocks, lambda_rule).run();
}

}  // namespace raylign
