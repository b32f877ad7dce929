// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/solve.h"

#include <ceres/crs_matrix.h>

#include "raylign/base/blas_threads.h"
#include "raylign/base/error.h"
#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/process_guards.h"
#include "raylign/ceres_backend/reprojection_problem.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "raylign/scene/bal_statistics.h"

namespace raylign::ceres_backend {
namespace {

// COLMAP's rule: a dense S up to 50 cameras, a sparse factor up to 1000, conjugate gradients
// beyond.
constexpr std::int64_t kMaxCamerasDense = 50;
constexpr std::int64_t kMaxCamerasSparse = 1000;
// Ceres allocates J and JᵀJ as dense matrices for dense_normal_cholesky; past this the machine
// would swap.
constexpr double kMaxDenseBytes = 8e9;

struct SolverChoice {
  LinearSolverType type;
  std::string reason;
};

SolverChoice choose_linear_solver(LinearSolverType requested, std::int64_t num_cameras) {
  if (requested != LinearSolverType::AUTO) return {requested, "requested"};
  const std::string count = std::to_string(num_cameras) + " cameras";
  if (num_cameras <= kMaxCamerasDense) {
    return {LinearSolverType::DENSE_SCHUR, "auto: " + count + " <= 50, so a dense S is cheapest"};
  }
  if (num_cameras <= kMaxCamerasSparse) {
    return {LinearSolverType::SPARSE_SCHUR,
            "auto: 50 < " + count + " <= 1000, so S is factored sparsely"};
  }
  return {LinearSolverType::ITERATIVE_SCHUR, "auto: " + count + " > 1000, so S is not factored"};
}

void check_dense_memory(const BalProblem& problem) {
  const double columns = 9.0 * problem.num_cameras() + 3.0 * problem.num_points();
  const double rows = 2.0 * problem.num_observations();
  const double bytes = 8.0 * columns * (rows + columns);
  if (bytes <= kMaxDenseBytes) return;
  throw OptionsError("LinearSolverOptions.type DENSE_NORMAL_CHOLESKY would allocate " +
                     std::to_string(static_cast<std::int64_t>(bytes / 1e9)) +
                     " GB of dense matrices for this problem (limit 8 GB); use a Schur solver");
}

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

}  // namespace

Summary solve(BalProblem& problem,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback) {
  if (problem.num_observations() == 0) return nothing_to_adjust("ceres");
  const Stopwatch stopwatch;
  const ScopedGlogSilence silence;
  const ScopedSingleThreadedBlas single_threaded_blas;
  const SolverChoice choice =
      choose_linear_solver(options.linear_solver.type, problem.num_cameras());
  if (choice.type == LinearSolverType::DENSE_NORMAL_CHOLESKY) check_dense_memory(problem);

  // asked before Ceres sees a number: it aborts the process on NaN parameters
  const std::string invalid = describe_invalid_residual(problem);
  if (!invalid.empty()) return failed_summary("ceres", invalid);
  const auto built = ReprojectionProblem::create(problem, config, options);

  BundleOptions resolved = options;
  resolved.linear_solver.type = choice.type;
  ceres::Solver::Options ceres_options = to_ceres(resolved);
  set_ordering(*built, ceres_options);
  const int num_residual_blocks = static_cast<int>(problem.num_observations());
  const double build_time_s = stopwatch.seconds();
  CallbackBridge bridge(callback, num_residual_blocks, build_time_s);
  ceres_options.callbacks.push_back(&bridge);
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(ceres_options, &built->ceres_problem(), &ceres_summary);
  if (bridge.pending_exception()) std::rethrow_exception(bridge.pending_exception());

  Summary summary = from_ceres(ceres_summary, options.lm);
  summary.linear_solver = choice.type;
  summary.linear_solver_reason = choice.reason;
  summary.iterations = bridge.iterations();
  ensure_first_row(summary, num_residual_blocks);
  summary.count_steps();
  if (summary.is_usable()) built->write_back(problem);
  summary.preprocessor_time_s += build_time_s;
  summary.total_time_s = stopwatch.seconds();
  return summary;
}

Linearization linearize(const BalProblem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options) {
  const ScopedGlogSilence silence;
  const std::string invalid = describe_invalid_residual(problem);
  if (!invalid.empty()) throw Error(invalid);
  const auto built = ReprojectionProblem::create(problem, config, options);

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
  built->ceres_problem().Evaluate(evaluate, &out.cost, &out.residuals,
                                  any_free ? &out.gradient : nullptr,
                                  any_free ? &jacobian : nullptr);
  out.num_columns = any_free ? jacobian.num_cols : 0;
  out.row_starts.assign(jacobian.rows.begin(), jacobian.rows.end());
  out.columns.assign(jacobian.cols.begin(), jacobian.cols.end());
  out.values = std::move(jacobian.values);
  if (!any_free) out.row_starts.assign(out.residuals.size() + 1, 0);
  return out;
}

}  // namespace raylign::ceres_backend
