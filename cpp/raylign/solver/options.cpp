// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/options.h"

#include "raylign/base/error.h"

namespace raylign {

// Every comparison is written so that NaN fails it.
void LmOptions::validate() const {
  require_option(max_num_iterations >= 0, "LmOptions.max_num_iterations", ">= 0",
                 max_num_iterations);
  require_option(max_solver_time_s > 0, "LmOptions.max_solver_time_s", "> 0 (s)",
                 max_solver_time_s);
  require_option(function_tolerance >= 0, "LmOptions.function_tolerance", ">= 0",
                 function_tolerance);
  require_option(gradient_tolerance >= 0, "LmOptions.gradient_tolerance", ">= 0",
                 gradient_tolerance);
  require_option(parameter_tolerance >= 0, "LmOptions.parameter_tolerance", ">= 0",
                 parameter_tolerance);
  require_option(min_lambda > 0, "LmOptions.min_lambda", "> 0", min_lambda);
  require_option(max_lambda > min_lambda && max_lambda <= 1e300, "LmOptions.max_lambda",
                 "> min_lambda and <= 1e300", max_lambda);
  require_option(initial_lambda >= min_lambda && initial_lambda < max_lambda,
                 "LmOptions.initial_lambda", "> 0 and within [min_lambda, max_lambda)",
                 initial_lambda);
  require_option(min_relative_decrease >= 0 && min_relative_decrease < 1,
                 "LmOptions.min_relative_decrease", "in [0, 1)", min_relative_decrease);
  require_option(min_diagonal > 0, "LmOptions.min_diagonal", "> 0", min_diagonal);
  require_option(max_diagonal >= min_diagonal && max_diagonal <= 1e300, "LmOptions.max_diagonal",
                 ">= min_diagonal and <= 1e300", max_diagonal);
  require_option(max_num_consecutive_invalid_steps >= 1,
                 "LmOptions.max_num_consecutive_invalid_steps", ">= 1",
                 max_num_consecutive_invalid_steps);
  require_option(num_threads >= 1 && num_threads <= 1024, "LmOptions.num_threads", "in [1, 1024]",
                 num_threads);
}

void LinearSolverOptions::validate() const {
  require_option(max_num_iterations >= 1, "LinearSolverOptions.max_num_iterations", ">= 1",
                 max_num_iterations);
  require_option(forcing_tolerance > 0 && forcing_tolerance < 1,
                 "LinearSolverOptions.forcing_tolerance", "in (0, 1)", forcing_tolerance);
  const bool may_iterate =
      type == LinearSolverType::ITERATIVE_SCHUR || type == LinearSolverType::AUTO;
  if (explicit_schur && !may_iterate) {
    throw OptionsError("LinearSolverOptions.explicit_schur needs type ITERATIVE_SCHUR");
  }
}

}  // namespace raylign
