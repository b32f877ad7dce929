// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Ceres' own autodiff formulation of a BAL problem beside raylign's analytic one through the same
// Ceres, solver and options, in turns and in one process. Prints one JSON line per solve.
//
//   bal_ceres_benchmark FILE [--repeats 3] [--tight] [--solver
//   dense_schur|sparse_schur|iterative_schur]
#include <ceres/ceres.h>

#include <cstdio>
#include <cstring>
#include <string>

#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/ceres_backend/process_guards.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "raylign/io/bal.h"
#include "support/autodiff_bal.h"

namespace {

using raylign::BalProblem;
using raylign::BundleOptions;
using raylign::PoseParametrization;

struct Arguments {
  std::string file;
  int repeats = 3;
  bool tight = false;
  raylign::LinearSolverType solver = raylign::LinearSolverType::DENSE_SCHUR;
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--tight") {
      arguments.tight = true;
    } else if (word == "--repeats" && i + 1 < argc) {
      arguments.repeats = std::atoi(argv[++i]);
    } else if (word == "--solver" && i + 1 < argc) {
      const std::string name = argv[++i];
      for (const auto type :
           {raylign::LinearSolverType::DENSE_SCHUR, raylign::LinearSolverType::SPARSE_SCHUR,
            raylign::LinearSolverType::ITERATIVE_SCHUR}) {
        if (raylign::to_string(type) == name) arguments.solver = type;
      }
    } else {
      arguments.file = word;
    }
  }
  return arguments;
}

void print_row(const char* system,
               const char* pose,
               double cost_before,
               double cost_after,
               int evaluations,
               double jacobian_s,
               double residual_s,
               double linear_s,
               double total_s,
               int iterations,
               std::int64_t observations) {
  std::printf(
      "{\"system\": \"%s\", \"pose\": \"%s\", \"initial_cost\": %.17g, \"final_cost\": %.17g, "
      "\"iterations\": %d, \"jacobian_evaluations\": %d, \"jacobian_time_s\": %.6f, "
      "\"jacobian_ns_per_observation\": %.2f, \"residual_time_s\": %.6f, \"linear_solver_time_s\": "
      "%.6f, "
      "\"total_time_s\": %.6f}\n",
      system, pose, cost_before, cost_after, iterations, evaluations, jacobian_s,
      1e9 * jacobian_s / evaluations / static_cast<double>(observations), residual_s, linear_s,
      total_s);
  std::fflush(stdout);
}

BundleOptions make_options(const Arguments& arguments) {
  BundleOptions options;
  options.linear_solver.type = arguments.solver;
  if (arguments.tight) {
    options.lm.max_num_iterations = 200;
    options.lm.function_tolerance = 1e-12;
    options.lm.gradient_tolerance = 1e-14;
    options.lm.parameter_tolerance = 1e-14;
  }
  return options;
}

void run_autodiff(BalProblem problem, const BundleOptions& options) {
  const raylign::ceres_backend::ScopedGlogSilence silence;
  const raylign::ceres_backend::ScopedSingleThreadedBlas blas;
  raylign::test::AutodiffBal autodiff(problem);
  const ceres::Solver::Summary s = autodiff.solve(raylign::ceres_backend::to_ceres(options));
  print_row("ceres_autodiff", "angle_axis", s.initial_cost, s.final_cost,
            s.num_jacobian_evaluations, s.jacobian_evaluation_time_in_seconds,
            s.residual_evaluation_time_in_seconds, s.linear_solver_time_in_seconds,
            s.total_time_in_seconds, static_cast<int>(s.iterations.size()) - 1,
            problem.num_observations());
}

void run_raylign(BalProblem problem, BundleOptions options, PoseParametrization pose) {
  options.pose_parametrization = pose;
  const raylign::Summary s = raylign::adjust(problem, {}, options);
  print_row("raylign_ceres", raylign::to_string(pose).c_str(), s.initial_cost, s.final_cost,
            1 + s.num_accepted, s.jacobian_time_s, s.residual_time_s, s.linear_solver_time_s,
            s.total_time_s, static_cast<int>(s.iterations.size()) - 1, problem.num_observations());
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = parse(argc, argv);
  const BalProblem problem = raylign::read_bal(arguments.file);
  const BundleOptions options = make_options(arguments);
  for (int i = 0; i < arguments.repeats; ++i) {
    run_autodiff(problem, options);
    run_raylign(problem, options, PoseParametrization::SE3);
    run_raylign(problem, options, PoseParametrization::ANGLE_AXIS);
  }
  return 0;
}
