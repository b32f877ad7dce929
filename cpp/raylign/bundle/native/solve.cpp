// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/solve.h"

#include "raylign/base/blas_threads.h"
#include "raylign/base/error.h"
#include "raylign/base/stopwatch.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/parametrization/constants.h"
#include "raylign/parametrization/start_check.h"
#include "raylign/solver/lm.h"

namespace raylign::native {
namespace {

void check_supported(const BundleOptions& options) {
  if (options.point_parametrization != PointParametrization::XYZ) {
    throw OptionsError("BundleOptions.point_parametrization must be XYZ with backend NATIVE, got " +
                       to_string(options.point_parametrization) + "; backend CERES has all three");
  }
  check_linear_solver(options.linear_solver);
}

// Nothing may move: one row, as from every other solve.
Summary evaluate_only(ReprojectionProblem& problem, const LmOptions& options, int num_blocks) {
  LmOptions once = options;
  once.max_num_iterations = 0;
  const Stopwatch clock;
  Summary summary = minimize(problem, once, nullptr, clock, num_blocks);
  summary.termination = Termination::CONVERGENCE;
  summary.message = "nothing to adjust: every parameter is held";
  return summary;
}

}  // namespace

Summary solve(BalProblem& problem,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback) {
  check_supported(options);
  if (problem.num_observations() == 0) return nothing_to_adjust("native");
  const Stopwatch clock;
  const ScopedSingleThreadedBlas single_threaded_blas;
  const std::string invalid = describe_invalid_start(problem, options.loss);
  if (!invalid.empty()) return failed_summary("native", invalid);
  ReprojectionProblem native_problem(problem, resolve_constants(problem, config), options);
  const double preprocessor_time_s = clock.seconds();

  const int num_blocks = static_cast<int>(problem.num_observations());
  Summary summary = native_problem.num_effective_parameters() == 0
                        ? evaluate_only(native_problem, options.lm, num_blocks)
                        : minimize(native_problem, options.lm, callback, clock, num_blocks);
  summary.backend = "native";
  summary.num_residuals = 2 * num_blocks;
  summary.num_effective_parameters = native_problem.num_effective_parameters();
  summary.linear_solver = native_problem.linear_solver();
  summary.linear_solver_reason = native_problem.linear_solver_reason();
  summary.num_threads = options.lm.num_threads;
  summary.deterministic = true;
  summary.preprocessor_time_s = preprocessor_time_s;
  if (summary.is_usable()) native_problem.write_back(problem);
  summary.total_time_s = clock.seconds();
  return summary;
}

}  // namespace raylign::native
