// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Ceres' own autodiff formulation of a BAL problem beside raylign's analytic one through the same
// Ceres, solver and options, and beside raylign's native engine (dense_schur only), in turns and in
// one process. Prints one JSON line per solve.
//
//   bal_benchmark FILE [--repeats 3] [--tight] [--threads 1]
//                 [--solver dense_schur|sparse_schur|iterative_schur]
#include <ceres/ceres.h>

#include <time.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "raylign/base/blas_threads.h"
#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/ceres_backend/process_guards.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "raylign/io/bal.h"
#include "support/autodiff_bal.h"

namespace {

using raylign::Backend;
using raylign::BalProblem;
using raylign::BundleOptions;
using raylign::PoseParametrization;

struct Arguments {
  std::string file;
  int repeats = 3;
  int threads = 1;
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
    } else if (word == "--threads" && i + 1 < argc) {
      arguments.threads = std::atoi(argv[++i]);
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

struct Row {
  const char* system;
  std::string pose;
  int jacobian_evaluations;
  double jacobian_s, residual_s, linear_s, preprocess_s, total_s;
  double cpu_s;                              // of this thread, preprocessing included
  std::vector<std::array<double, 2>> trace;  // (seconds since the call, cost) of each iteration
};

double thread_cpu_s() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void print_row(const Row& row, std::int64_t observations) {
  const auto n = static_cast<double>(observations);
  const std::size_t iterations = std::max<std::size_t>(1, row.trace.size() - 1);
  std::printf(
      "{\"system\": \"%s\", \"pose\": \"%s\", \"iterations\": %zu, "
      "\"jacobian_evaluations\": %d, \"jacobian_time_s\": %.6f, "
      "\"jacobian_ns_per_observation\": %.2f, \"residual_time_s\": %.6f, "
      "\"linear_solver_time_s\": %.6f, \"preprocessor_time_s\": %.6f, \"total_time_s\": %.6f, "
      "\"cpu_time_s\": %.6f, \"ns_per_observation_and_iteration\": %.2f, ",
      row.system, row.pose.c_str(), row.trace.size() - 1, row.jacobian_evaluations, row.jacobian_s,
      1e9 * row.jacobian_s / row.jacobian_evaluations / n, row.residual_s, row.linear_s,
      row.preprocess_s, row.total_s, row.cpu_s,
      1e9 * (row.total_s - row.preprocess_s) / static_cast<double>(iterations) / n);
  std::printf("\"initial_cost\": %.17g, \"final_cost\": %.17g, \"trace\": [", row.trace.front()[1],
              row.trace.back()[1]);
  for (std::size_t i = 0; i < row.trace.size(); ++i) {
    std::printf("%s[%.6f, %.17g]", i == 0 ? "" : ", ", row.trace[i][0], row.trace[i][1]);
  }
  std::printf("]}\n");
  std::fflush(stdout);
}

BundleOptions make_options(const Arguments& arguments) {
  BundleOptions options;
  options.linear_solver.type = arguments.solver;
  options.lm.num_threads = arguments.threads;
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
  const raylign::ScopedSingleThreadedBlas blas;
  raylign::test::AutodiffBal autodiff(problem);
  const double cpu_s = thread_cpu_s();
  const ceres::Solver::Summary s = autodiff.solve(raylign::ceres_backend::to_ceres(options));
  Row row{"ceres_autodiff",
          "angle_axis",
          s.num_jacobian_evaluations,
          s.jacobian_evaluation_time_in_seconds,
          s.residual_evaluation_time_in_seconds,
          s.linear_solver_time_in_seconds,
          s.preprocessor_time_in_seconds,
          s.total_time_in_seconds,
          thread_cpu_s() - cpu_s,
          {}};
  for (const auto& it : s.iterations) {
    const double cost = row.trace.empty() ? it.cost : std::min(it.cost, row.trace.back()[1]);
    row.trace.push_back({it.cumulative_time_in_seconds, cost});
  }
  print_row(row, problem.num_observations());
}

void run_raylign(BalProblem problem,
                 BundleOptions options,
                 Backend backend,
                 PoseParametrization pose) {
  options.backend = backend;
  options.pose_parametrization = pose;
  const double cpu_s = thread_cpu_s();
  const raylign::Summary s = raylign::adjust(problem, {}, options);
  Row row{backend == Backend::NATIVE ? "raylign_native" : "raylign_ceres",
          raylign::to_string(pose),
          1 + s.num_accepted,
          s.jacobian_time_s,
          s.residual_time_s,
          s.linear_solver_time_s,
          s.preprocessor_time_s,
          s.total_time_s,
          thread_cpu_s() - cpu_s,
          {}};
  for (const raylign::IterationSummary& it : s.iterations) {
    const double cost = row.trace.empty() ? it.cost : std::min(it.cost, row.trace.back()[1]);
    row.trace.push_back({it.cumulative_time_s, cost});
  }
  print_row(row, problem.num_observations());
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = parse(argc, argv);
  const BalProblem problem = raylign::read_bal(arguments.file);
  const BundleOptions options = make_options(arguments);
  for (int i = 0; i < arguments.repeats; ++i) {
    run_autodiff(problem, options);
    for (const auto pose : {PoseParametrization::SE3, PoseParametrization::ANGLE_AXIS}) {
      run_raylign(problem, options, Backend::CERES, pose);
      if (options.linear_solver.type == raylign::LinearSolverType::DENSE_SCHUR) {
        run_raylign(problem, options, Backend::NATIVE, pose);
      }
    }
  }
  return 0;
}
