// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/ceres_problem.h"

#include <algorithm>
#include <string>

#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/summary_bridge.h"

namespace raylign::ceres_backend {
namespace {

// Ceres' Schur solvers want the elimination order: points first.
void set_ordering(const CeresProblem& problem, ceres::Solver::Options& options) {
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

}  // namespace

bool CeresProblem::has_free_point() const {
  return std::any_of(point_blocks_.begin(), point_blocks_.end(),
                     [&](double* block) { return !ceres_->IsParameterBlockConstant(block); });
}

ceres::Problem::Options problem_options() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::TAKE_OWNERSHIP;  // Ceres frees a shared manifold once
  options.disable_all_safety_checks = true;  // the arrays are validated, the blocks are ours
  return options;
}

Summary run_ceres(CeresProblem& problem,
                  const BundleOptions& options,
                  const LinearSolverChoice& choice,
                  int num_residual_blocks,
                  const IterationCallback& callback,
                  const Stopwatch& clock) {
  BundleOptions resolved = options;
  resolved.linear_solver.type = choice.type;
  ceres::Solver::Options ceres_options = to_ceres(resolved);
  set_ordering(problem, ceres_options);
  const double build_time_s = clock.seconds();
  problem.save_state();
  CallbackBridge bridge(callback, num_residual_blocks, build_time_s, [&] { problem.save_state(); });
  ceres_options.callbacks.push_back(&bridge);
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(ceres_options, &problem.ceres_problem(), &ceres_summary);
  if (bridge.pending_exception()) {
    problem.restore_saved_state();
    std::rethrow_exception(bridge.pending_exception());
  }
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
    problem.restore_saved_state();
  } else {
    ensure_first_row(summary, num_residual_blocks);
  }
  summary.preprocessor_time_s += build_time_s;
  return summary;
}

}  // namespace raylign::ceres_backend
