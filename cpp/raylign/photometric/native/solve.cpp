// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/solve.h"

#include "raylign/base/blas_threads.h"
#include "raylign/base/error.h"
#include "raylign/base/stopwatch.h"
#include "raylign/photometric/native/patch_problem.h"
#include "raylign/solver/lm.h"

namespace raylign::native {
namespace {

// The dense system of the images: 1.2 GB.
constexpr int kMaxColumns = 12000;

}  // namespace

void check_solvable(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options) {
  validate_patch_solve(scene, constraints, options);
  const int columns = ImageColumns(scene, constraints).num_columns();
  require_option(columns <= kMaxColumns, "free parameters of all images",
                 "<= 12000 with backend NATIVE, whose system is dense", columns);
}

Summary solve_patches(PatchScene& scene,
                      const PatchConstraints& constraints,
                      const PatchSolveOptions& options,
                      const IterationCallback& callback,
                      const InterruptCheck& interrupted) {
  const Stopwatch clock;
  check_solvable(scene, constraints, options);
  if (scene.num_edges() == 0) return nothing_to_adjust("native");
  const ScopedSingleThreadedBlas single_threaded_blas;
  PatchProblem problem(scene, constraints, options, interrupted);
  const double preprocessor_time_s = clock.seconds();
  LmOptions lm = options.lm;
  const bool is_fixed = problem.num_effective_parameters() == 0;
  if (is_fixed) lm.max_num_iterations = 0;
  Summary summary = minimize(problem, lm, callback, clock, static_cast<int>(scene.num_edges()),
                             options.lambda_rule);
  if (is_fixed) {
    summary.termination = Termination::CONVERGENCE;
    summary.message = "nothing to adjust: every parameter is held";
  }
  summary.backend = "native";
  summary.num_residuals = static_cast<int>(problem.num_residuals());
  summary.num_effective_parameters = problem.num_effective_parameters();
  summary.linear_solver = LinearSolverType::DENSE_SCHUR;
  summary.linear_solver_reason = "the images' reduced system is dense";
  summary.num_threads = options.lm.num_threads;
  summary.deterministic = true;
  summary.preprocessor_time_s = preprocessor_time_s;
  if (summary.is_usable()) problem.write_back(scene);
  summary.total_time_s = clock.seconds();
  return summary;
}

double max_diagonal(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options) {
  check_solvable(scene, constraints, options);
  PatchProblem problem(scene, constraints, options);
  problem.linearize();
  return problem.max_diagonal();
}

}  // namespace raylign::native
