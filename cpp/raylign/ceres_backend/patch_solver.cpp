// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_solver.h"

#include "raylign/base/blas_threads.h"
#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/patch_problem.h"
#include "raylign/ceres_backend/process_guards.h"

namespace raylign::ceres_backend {

Summary solve_patches(PatchScene& scene,
                      const PatchConstraints& constraints,
                      const PatchSolveOptions& options,
                      const IterationCallback& callback) {
  const Stopwatch clock;
  validate_patch_solve(scene, constraints, options);
  const ScopedGlogSilence silence;
  const ScopedSingleThreadedBlas single_threaded_blas;
  PatchProblem problem(scene, constraints, options);
  const std::string invalid = problem.invalid_start();
  if (!invalid.empty()) return failed_summary("ceres", invalid);
  if (problem.blocks().empty()) return nothing_to_adjust("ceres");
  BundleOptions ceres_options;
  ceres_options.lm = options.lm;
  const LinearSolverChoice choice =
      choose_linear_solver(LinearSolverType::AUTO, scene.num_images(), problem.has_free_point());
  Summary summary;
  try {
    summary = run_ceres(problem, ceres_options, choice, static_cast<int>(scene.num_edges()),
                        callback, clock);
  } catch (...) {
    problem.write_best();
    throw;
  }
  problem.write_best();
  summary.total_time_s = clock.seconds();
  return summary;
}

}  // namespace raylign::ceres_backend
