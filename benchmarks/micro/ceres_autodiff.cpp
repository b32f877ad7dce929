// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Ceres' own BAL example as a benchmark worker: one block of nine numbers per camera, automatic
// differentiation. Speaks the protocol of benchmarks/workers/protocol.py.
//
//   ceres_autodiff FILE --solver dense_schur|sparse_schur|iterative_schur|iterative_explicit
//     --threads N --max-iterations N --function-tolerance X --time-limit S --parameters FILE
#include <ceres/ceres.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "raylign/base/blas_threads.h"
#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/process_guards.h"
#include "raylign/ceres_backend/summary_bridge.h"
#include "raylign/io/bal.h"
#include "support/autodiff_bal.h"

namespace {

/// "VmRSS" (now) or "VmHWM" (its maximum) of this process, in bytes.
long status_bytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == field + ":") {
      long kibibytes = 0;
      status >> kibibytes;
      return 1024 * kibibytes;
    }
  }
  return 0;
}

raylign::BundleOptions make_options(std::map<std::string, std::string>& flags) {
  raylign::BundleOptions options;
  const std::string solver = flags["--solver"];
  options.linear_solver.explicit_schur = solver == "iterative_explicit";
  options.linear_solver.type = raylign::LinearSolverType::ITERATIVE_SCHUR;
  for (const auto type :
       {raylign::LinearSolverType::DENSE_SCHUR, raylign::LinearSolverType::SPARSE_SCHUR}) {
    if (raylign::to_string(type) == solver) options.linear_solver.type = type;
  }
  options.lm.num_threads = std::stoi(flags["--threads"]);
  options.lm.max_num_iterations = std::stoi(flags["--max-iterations"]);
  options.lm.function_tolerance = std::stod(flags["--function-tolerance"]);
  options.lm.gradient_tolerance = 1e-14;
  options.lm.parameter_tolerance = 1e-14;
  options.lm.max_solver_time_s = std::stod(flags["--time-limit"]);
  return options;
}

void write_parameters(const raylign::BalProblem& problem, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(problem.cameras.data()),
             static_cast<std::streamsize>(sizeof(double) * problem.cameras.size()));
  file.write(reinterpret_cast<const char*>(problem.points.data()),
             static_cast<std::streamsize>(sizeof(double) * problem.points.size()));
}

void print_trace(const ceres::Solver::Summary& summary) {
  std::printf("\"trace\": [");
  double cost = summary.initial_cost;
  for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
    const auto& it = summary.iterations[i];
    cost = std::min(cost, it.cost);
    std::printf("%s[%.6f, %.17g]", i == 0 ? "" : ", ", it.cumulative_time_in_seconds, cost);
  }
  std::printf("]");
}

}  // namespace

int main(int argc, char** argv) {
  const long baseline_bytes = status_bytes("VmRSS");
  std::map<std::string, std::string> flags;
  for (int i = 2; i + 1 < argc; i += 2) flags[argv[i]] = argv[i + 1];
  const raylign::BundleOptions options = make_options(flags);
  const raylign::ceres_backend::ScopedGlogSilence silence;
  const raylign::ScopedSingleThreadedBlas blas;

  raylign::Stopwatch clock;
  raylign::BalProblem problem = raylign::read_bal(argv[1]);
  const double parsed_s = clock.seconds();
  raylign::test::AutodiffBal autodiff(problem);
  const double built_s = clock.seconds();
  const ceres::Solver::Summary s = autodiff.solve(raylign::ceres_backend::to_ceres(options));
  const double solved_s = clock.seconds();
  const long peak_bytes = status_bytes("VmHWM");
  write_parameters(problem, flags["--parameters"]);

  std::printf(
      "{\"parse_s\": %.6f, \"build_s\": %.6f, \"preprocess_s\": %.6f, \"solve_s\": %.6f, "
      "\"jacobian_s\": %.6f, \"residual_s\": %.6f, \"linear_solver_s\": %.6f, "
      "\"baseline_bytes\": %ld, \"peak_bytes\": %ld, \"num_residuals\": %d, "
      "\"linear_solver\": \"%s\", \"message\": \"Ceres %s: %s\", ",
      parsed_s, built_s - parsed_s, s.preprocessor_time_in_seconds, solved_s - built_s,
      s.jacobian_evaluation_time_in_seconds, s.residual_evaluation_time_in_seconds,
      s.linear_solver_time_in_seconds, baseline_bytes, peak_bytes, s.num_residuals,
      ceres::LinearSolverTypeToString(s.linear_solver_type_used), CERES_VERSION_STRING,
      s.message.c_str());
  print_trace(s);
  std::printf("}\n");
  return s.IsSolutionUsable() ? 0 : 1;
}
