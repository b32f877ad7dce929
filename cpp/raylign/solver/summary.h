// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "raylign/solver/options.h"

namespace raylign {

enum class Termination {
  NOT_RUN,         ///< the solver was not called
  CONVERGENCE,     ///< a tolerance was met, or λ reached max_lambda; message says which
  MAX_ITERATIONS,  ///< max_num_iterations spent; the state is the best one found
  TIME_LIMIT,      ///< max_solver_time_s spent; the state is the best one found
  USER_STOPPED,    ///< the callback or Ctrl-C stopped it; the state is the best one found
  FAILURE,         ///< no finite step could be made; the state is the one before the failure
};

/// One row per iteration; row 0 is the starting point. Plain data: a NumPy structured array in
/// Python.
struct IterationSummary {
  std::int32_t iteration = -1;
  std::int32_t linear_solver_iterations = 0;  ///< 0 for direct solvers at row 0, else >= 1.
  std::int32_t num_residual_blocks = 0;       ///< observations in the cost ("edges" in g2o's log)
  bool step_is_valid = false;                 ///< finite trial cost, positive model decrease
  bool step_is_accepted = false;
  double cost = -1.0;               ///< ½ Σ ρ(‖r‖²) after the iteration; chi2 of g2o = 2 · cost
  double cost_change = 0.0;         ///< > 0: the cost went down
  double gain_ratio = 0.0;          ///< actual / predicted decrease
  double gradient_max_norm = -1.0;  ///< max |x − (x ⊞ −g)|
  double step_norm = 0.0;           ///< ‖δ‖
  double lambda = -1.0;             ///< damping used for the next step
  double linear_solver_time_s = 0.0;
  double iteration_time_s = 0.0;
  double cumulative_time_s = 0.0;  ///< since the call, preprocessing included
};

enum class CallbackAction { CONTINUE, STOP };
/// Called after each iteration (row 0 included). STOP ends the solve with USER_STOPPED and the best
/// state.
using IterationCallback = std::function<CallbackAction(const IterationSummary&)>;

/// Asked inside a long iteration, from the solving thread; true stops it, with USER_STOPPED and the
/// best state.
using InterruptCheck = std::function<bool()>;

/// What a solve did. The same struct from every engine. Impossible values until a solver fills
/// them.
struct Summary {
  Termination termination = Termination::NOT_RUN;
  std::string message = "the solver was not called";
  std::string backend = "none";  ///< "ceres" or "native"
  std::string backend_reason;    ///< why AUTO took it, or "requested"
  double initial_cost = -1.0;    ///< ½ Σ ρ(‖r‖²)
  double final_cost = -1.0;
  int num_accepted = 0;
  int num_rejected = 0;
  int num_residuals = 0;             ///< scalar residuals
  int num_effective_parameters = 0;  ///< tangent dimension of everything that may move
  LinearSolverType linear_solver = LinearSolverType::AUTO;  ///< what ran (never AUTO after a solve)
  std::string linear_solver_reason;                         ///< why AUTO picked it, or "requested"
  std::string jacobian_storage = "double";  ///< or "none", "float", "float, then double: why"
  int num_threads = 0;
  bool deterministic = false;  ///< same input, same bits, on this machine
  double preprocessor_time_s = 0.0;
  double residual_time_s = 0.0;
  double jacobian_time_s = 0.0;
  double linear_solver_time_s = 0.0;
  double total_time_s = 0.0;
  std::vector<IterationSummary> iterations;

  /// True when the state is at least as good as the start: everything but NOT_RUN and a FAILURE
  /// before the first accepted step.
  bool is_usable() const;
  /// Sets num_accepted and num_rejected from the iterations.
  void count_steps();
  /// One line: termination, costs, iterations, seconds.
  std::string brief_report() const;
  /// Several lines, for people.
  std::string full_report() const;
};

/// Termination::FAILURE before anything was solved.
Summary failed_summary(const std::string& backend, const std::string& message);
/// A problem without observations is solved as it stands.
Summary nothing_to_adjust(const std::string& backend);

std::string to_string(Termination termination);
std::string to_string(LinearSolverType type);
std::string to_string(Preconditioner preconditioner);

}  // namespace raylign
