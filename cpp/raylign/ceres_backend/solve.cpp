// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/solve.h"

#include <ceres/crs_matrix.h>

#include <algorithm>

#include "raylign/base/blas_threads.h"
#include "raylign/base/error.h"
#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/linear_solver_choice.h"
#include "raylign/ceres_backend/process_guards.h"
#include "raylign/ceres_backend/reprojection_problem.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "raylign/parametrization/start_check.h"

namespace raylign::ceres_backend {
namespace {

// Ceres' Schur solvers want the elimination order: points first.
void set_ordering(ReprojectionProblem& problem, ceres::Solver::Options& options) {
  if (options.linear_solver_type == ceres::DENSE_NORMAL_CHOLESKY) return;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (double* block : problem.blocks()) ordering->AddElementToGroup(block, 1);
  for (double* block : problem.point_blocks()) ordering->AddElementToGroup(block, 0);
  options.linear_solver_ordering = ordering;
}

// Ceres reports no iteration when every block is constant; a caller always finds row 0.
void ensure_first_row(Summary& summary, int num_residual_blocks) {
  if (!summary.iterations.empty()) return;
  IterationSummary row;
  row.iteration = 0;
  row.cost = summary.initial_cost;
  row.num_residual_blocks = num_residual_blocks;
  summary.iterations.push_back(row);
}

// After a failure Ceres forgets the costs; the rows have them.
void adopt_costs_of_rows(Summary& summary) {
  if (summary.iterations.empty()) return;
  summary.initial_cost = summary.iterations.front().cost;
  summary.final_cost = summary.initial_cost;
  for (const IterationSummary& row : summary.iterations) {
    if (row.step_is_accepted) summary.final_cost = row.cost;
  }
}

bool has_free_point(ReprojectionProblem& problem) {
  return std::any_of(
      problem.point_blocks().begin(), problem.point_blocks().end(),
      [&](double* block) { return !problem.ceres_problem().IsParameterBlockConstant(block); });
}

}  // namespace

Summary solve(BundleScene& scene,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback) {
  check_preconditioner(options.linear_solver);
  if (scene.num_observations() == 0) return nothing_to_adjust("ceres");
  const Stopwatch stopwatch;
  const ScopedGlogSilence silence;
  const ScopedSingleThreadedBlas single_threaded_blas;
  // asked before Ceres sees a number: it aborts the process on NaN parameters
  const std::string invalid = describe_invalid_start(scene, options.loss);
  if (!invalid.empty()) return failed_summary("ceres", invalid);
  const auto built = ReprojectionProblem::create(scene, config, options);
  const bool eliminates = has_free_point(*built);
  LinearSolverChoice choice = choose_linear_solver(options.linear_solver.type, scene, eliminates);
  check_ceres_limits(scene, choice.type, eliminates);

  BundleOptions resolved = options;
  resolved.linear_solver.type = choice.type;
  ceres::Solver::Options ceres_options = to_ceres(resolved);
  set_ordering(*built, ceres_options);
  const int num_residual_blocks = static_cast<int>(scene.num_observations());
  const double build_time_s = stopwatch.seconds();
  CallbackBridge bridge(callback, num_residual_blocks, build_time_s, [&] { built->save_state(); });
  ceres_options.callbacks.push_back(&bridge);
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(ceres_options, &built->ceres_problem(), &ceres_summary);
  if (bridge.pending_exception()) std::rethrow_exception(bridge.pending_exception());

  Summary summary = from_ceres(ceres_summary, options.lm);
  summary.linear_solver = choice.type;
  summary.linear_solver_reason = choice.reason;
  if (ceres_summary.linear_solver_type_used != ceres_options.linear_solver_type) {
    summary.linear_solver_reason +=
        std::string("; Ceres ran ") +
        ceres::LinearSolverTypeToString(ceres_summary.linear_solver_type_used);
  }
  summary.iterations = bridge.iterations();
  summary.count_steps();
  if (summary.termination == Termination::FAILURE) {
    adopt_costs_of_rows(summary);
    if (summary.num_accepted > 0) built->restore_saved_state();
  } else {
    ensure_first_row(summary, num_residual_blocks);
  }
  if (summary.is_usable()) built->write_back(scene);
  summary.preprocessor_time_s += build_time_s;
  summary.total_time_s = stopwatch.seconds();
  return summary;
}

Linearization linearize(const BundleScene& scene,
                        const BundleConfig& config,
                        const BundleOptions& options) {
  const ScopedGlogSilence silence;
  const std::string invalid = describe_invalid_start(scene, options.loss);
  if (!invalid.empty()) throw Error(invalid);
  const auto built = ReprojectionProblem::create(scene, config, options);

  ceres::Problem::EvaluateOptions evaluate;
  evaluate.num_threads = options.lm.num_threads;
  for (double* block : built->blocks()) {
    if (!built->ceres_problem().IsParameterBlockConstant(block)) {
      evaluate.parameter_blocks.push_back(block);
    }
  }
  Linearization out;
  ceres::CRSMatrix jacobian;
  // An empty list would mean "all blocks" to Ceres, held ones included.
  const bool any_free = !evaluate.parameter_blocks.empty();
  if (!built->ceres_problem().Evaluate(evaluate, &out.cost, &out.residuals,
                                       any_free ? &out.gradient : nullptr,
                                       any_free ? &jacobian : nullptr)) {
    throw Error("a residual or a Jacobian is not finite at the current state");
  }
  out.num_columns = any_free ? jacobian.num_cols : 0;
  out.row_starts.assign(jacobian.rows.begin(), jacobian.rows.end());
  out.columns.assign(jacobian.cols.begin(), jacobian.cols.end());
  out.values = std::move(jacobian.values);
  if (!any_free) out.row_starts.assign(out.residuals.size() + 1, 0);
  return out;
}

}  // namespace raylign::ceres_backend
