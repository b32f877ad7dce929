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

// The blocks of S have nine rows, whatever the camera.
std::string too_many_intrinsics(const BundleScene& scene, const BundleConfig& config) {
  if (scene.num_intrinsics() <= 3) return "";
  const Constants held = resolve_constants(scene, config);
  for (std::int64_t i = 0; i < scene.num_cameras(); ++i) {
    const int num_free = count_free(held.intrinsics[i]);
    if (num_free <= 3) continue;
    return "backend NATIVE moves at most 3 intrinsics of a camera, but camera " +
           std::to_string(i) + " has " + std::to_string(num_free) +
           " free; hold the others (BundleConfig) or use backend CERES";
  }
  return "";
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

std::string missing_feature(const BundleScene& scene,
                            const BundleConfig& config,
                            const BundleOptions& options) {
  if (options.point_parametrization == PointParametrization::INVERSE_DEPTH) {
    return "BundleOptions.point_parametrization must be XYZ or HOMOGENEOUS with backend NATIVE, "
           "got inverse_depth; backend CERES has all three";
  }
  const std::string solver = missing_linear_solver(options.linear_solver);
  return solver.empty() ? too_many_intrinsics(scene, config) : solver;
}

Summary solve(BundleScene& scene,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback,
              const InterruptCheck& interrupted) {
  const std::string missing = missing_feature(scene, config, options);
  if (!missing.empty()) throw OptionsError(missing);
  check_linear_solver(options.linear_solver);
  if (scene.num_observations() == 0) return nothing_to_adjust("native");
  const Stopwatch clock;
  const ScopedSingleThreadedBlas single_threaded_blas;
  const std::string invalid = describe_invalid_start(scene, options.loss);
  if (!invalid.empty()) return failed_summary("native", invalid);
  const Constants held = resolve_constants(scene, config);
  check_point_constants(held, options.point_parametrization);
  const auto stop = [&] {
    return clock.seconds() >= options.lm.max_solver_time_s || (interrupted && interrupted());
  };
  ReprojectionProblem native_problem(scene, held, options, stop);
  const double preprocessor_time_s = clock.seconds();

  const int num_blocks = static_cast<int>(scene.num_observations());
  const LambdaRule rule = options.parity ? LambdaRule::CERES : LambdaRule::FAST;
  Summary summary = native_problem.num_effective_parameters() == 0
                        ? evaluate_only(native_problem, options.lm, num_blocks)
                        : minimize(native_problem, options.lm, callback, clock, num_blocks, rule);
  summary.backend = "native";
  summary.num_residuals = 2 * num_blocks;
  summary.num_effective_parameters = native_problem.num_effective_parameters();
  summary.linear_solver = native_problem.linear_solver();
  summary.linear_solver_reason = native_problem.linear_solver_reason();
  summary.jacobian_storage = native_problem.jacobian_storage();
  summary.num_threads = options.lm.num_threads;
  summary.deterministic = true;
  summary.preprocessor_time_s = preprocessor_time_s;
  if (summary.is_usable()) native_problem.write_back(scene);
  summary.total_time_s = clock.seconds();
  return summary;
}

}  // namespace raylign::native
