// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/summary_bridge.h"

#include <algorithm>
#include <thread>

namespace raylign::ceres_backend {
namespace {

ceres::LinearSolverType to_ceres(LinearSolverType type) {
  switch (type) {
    case LinearSolverType::DENSE_NORMAL_CHOLESKY:
      return ceres::DENSE_NORMAL_CHOLESKY;
    case LinearSolverType::SPARSE_SCHUR:
      return ceres::SPARSE_SCHUR;
    case LinearSolverType::ITERATIVE_SCHUR:
      return ceres::ITERATIVE_SCHUR;
    case LinearSolverType::DENSE_SCHUR:
    case LinearSolverType::AUTO:
      break;  // AUTO is resolved before
  }
  return ceres::DENSE_SCHUR;
}

ceres::PreconditionerType to_ceres(Preconditioner preconditioner) {
  switch (preconditioner) {
    case Preconditioner::IDENTITY:
      return ceres::IDENTITY;
    case Preconditioner::JACOBI:
      return ceres::JACOBI;
    case Preconditioner::CLUSTER_JACOBI:
      return ceres::CLUSTER_JACOBI;
    case Preconditioner::CLUSTER_TRIDIAGONAL:
      return ceres::CLUSTER_TRIDIAGONAL;
    case Preconditioner::AUTO:
    case Preconditioner::SCHUR_JACOBI:
    case Preconditioner::TWO_LEVEL:
    case Preconditioner::STALE_FACTOR:
      break;  // the last two are refused before
  }
  return ceres::SCHUR_JACOBI;
}

Termination to_termination(const ceres::Solver::Summary& summary, const LmOptions& options) {
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
      return Termination::CONVERGENCE;
    case ceres::NO_CONVERGENCE: {
      const int last = summary.iterations.empty() ? 0 : summary.iterations.back().iteration;
      return last >= options.max_num_iterations ? Termination::MAX_ITERATIONS
                                                : Termination::TIME_LIMIT;
    }
    case ceres::USER_SUCCESS:
      return Termination::USER_STOPPED;
    case ceres::USER_FAILURE:
    case ceres::FAILURE:
      break;
  }
  return Termination::FAILURE;
}

}  // namespace

ceres::Solver::Options to_ceres(const BundleOptions& options) {
  const LmOptions& lm = options.lm;
  ceres::Solver::Options out;
  out.minimizer_type = ceres::TRUST_REGION;
  out.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  out.max_num_iterations = lm.max_num_iterations;
  out.max_solver_time_in_seconds = std::min(lm.max_solver_time_s, 1e9);  // Ceres' own "for ever"
  out.function_tolerance = lm.function_tolerance;
  out.gradient_tolerance = lm.gradient_tolerance;
  out.parameter_tolerance = lm.parameter_tolerance;
  out.initial_trust_region_radius = 1.0 / lm.initial_lambda;
  out.max_trust_region_radius = 1.0 / lm.min_lambda;
  out.min_trust_region_radius = 1.0 / lm.max_lambda;
  out.min_relative_decrease = lm.min_relative_decrease;
  out.min_lm_diagonal = lm.min_diagonal;
  out.max_lm_diagonal = lm.max_diagonal;
  out.max_num_consecutive_invalid_steps = lm.max_num_consecutive_invalid_steps;
  out.jacobi_scaling = lm.jacobi_scaling;
  // More threads than processors only cost memory: Ceres gives each a gradient of its own.
  const int num_processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  out.num_threads = std::min(lm.num_threads, num_processors);
  out.linear_solver_type = to_ceres(options.linear_solver.type);
  out.preconditioner_type = to_ceres(options.linear_solver.preconditioner);
  out.use_explicit_schur_complement = options.linear_solver.explicit_schur;
  out.max_linear_solver_iterations = options.linear_solver.max_num_iterations;
  out.eta = options.linear_solver.forcing_tolerance;
  out.dense_linear_algebra_library_type =
      ceres::LAPACK;  // OpenBLAS; Debian's Eigen kernels are SSE2
  out.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  out.update_state_every_iteration = true;  // the callback sees, and keeps, each accepted state
  out.logging_type = ceres::SILENT;
  out.minimizer_progress_to_stdout = false;
  return out;
}

Summary from_ceres(const ceres::Solver::Summary& summary, const LmOptions& options) {
  Summary out;
  out.termination = to_termination(summary, options);
  out.message = summary.message;
  out.backend = "ceres";
  out.initial_cost = summary.initial_cost;
  out.final_cost = summary.final_cost;
  out.num_residuals = summary.num_residuals_reduced;
  out.num_effective_parameters = summary.num_effective_parameters_reduced;
  out.num_threads = summary.num_threads_used;
  out.deterministic = options.num_threads == 1;
  out.preprocessor_time_s = summary.preprocessor_time_in_seconds;
  out.residual_time_s = summary.residual_evaluation_time_in_seconds;
  out.jacobian_time_s = summary.jacobian_evaluation_time_in_seconds;
  out.linear_solver_time_s = summary.linear_solver_time_in_seconds;
  out.total_time_s = summary.total_time_in_seconds;
  return out;
}

ceres::CallbackReturnType CallbackBridge::operator()(const ceres::IterationSummary& summary) {
  IterationSummary row;
  row.iteration = summary.iteration;
  row.linear_solver_iterations = std::max(0, summary.linear_solver_iterations);
  row.num_residual_blocks = num_residual_blocks_;
  const bool is_step = summary.iteration > 0;  // Ceres calls its starting point a successful step
  row.step_is_valid = is_step && summary.step_is_valid;
  row.step_is_accepted = is_step && summary.step_is_successful;
  row.cost = summary.cost;
  row.cost_change = summary.cost_change;
  row.gain_ratio = summary.relative_decrease;
  row.gradient_max_norm = summary.gradient_max_norm;
  row.step_norm = summary.step_norm;
  row.lambda = 1.0 / summary.trust_region_radius;
  row.linear_solver_time_s = summary.step_solver_time_in_seconds;
  row.iteration_time_s = summary.iteration_time_in_seconds;
  row.cumulative_time_s = time_before_s_ + summary.cumulative_time_in_seconds;
  if (is_step && !row.step_is_accepted) {  // Ceres tells the cost of the step that it refused
    row.cost = iterations_.back().cost;
    row.cost_change = 0.0;
  }
  iterations_.push_back(row);
  if (row.step_is_accepted) on_accepted_();
  if (!callback_) return ceres::SOLVER_CONTINUE;
  try {
    return callback_(row) == CallbackAction::STOP ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                  : ceres::SOLVER_CONTINUE;
  } catch (...) {
    pending_exception_ = std::current_exception();
    return ceres::SOLVER_ABORT;
  }
}

}  // namespace raylign::ceres_backend
