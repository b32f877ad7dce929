// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/solve.h"

#include <ceres/crs_matrix.h>

#include "raylign/base/blas_threads.h"
#include "raylign/base/error.h"
#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/linear_solver_choice.h"
#include "raylign/ceres_backend/process_guards.h"
#include "raylign/ceres_backend/reprojection_problem.h"
#include "raylign/parametrization/start_check.h"

namespace raylign::ceres_backend {

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
  const bool eliminates = built->has_free_point();
  const LinearSolverChoice choice =
      choose_linear_solver(options.linear_solver.type, scene.num_cameras(), eliminates);
  check_ceres_limits(scene, choice.type, eliminates);
  Summary summary = run_ceres(*built, options, choice, static_cast<int>(scene.num_observations()),
                              callback, stopwatch);
  if (summary.is_usable()) built->write_back(scene);
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
