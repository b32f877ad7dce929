// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/summary.h"

#include <cstdarg>
#include <cstdio>

namespace raylign {
namespace {

// printf-style text of bounded length: reports only.
std::string format(const char* pattern, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(buffer, sizeof(buffer), pattern, arguments);
  va_end(arguments);
  return buffer;
}

}  // namespace

bool Summary::is_usable() const {
  if (termination == Termination::FAILURE) return num_accepted > 0;
  return termination != Termination::NOT_RUN;
}

void Summary::count_steps() {
  num_accepted = num_rejected = 0;
  for (const IterationSummary& row : iterations) {
    if (row.iteration == 0) continue;
    (row.step_is_accepted ? num_accepted : num_rejected) += 1;
  }
}

std::string Summary::brief_report() const {
  if (!is_usable()) return to_string(termination) + ": " + message;
  return format("%s: cost %.6e -> %.6e, %d accepted and %d rejected steps, %.3f s",
                to_string(termination).c_str(), initial_cost, final_cost, num_accepted,
                num_rejected, total_time_s);
}

std::string Summary::full_report() const {
  if (!is_usable()) return brief_report() + "\n";
  std::string text;
  text += format("backend            %s (%d thread%s, %s)\n", backend.c_str(), num_threads,
                 num_threads == 1 ? "" : "s",
                 deterministic ? "bitwise reproducible" : "not bitwise reproducible");
  if (!backend_reason.empty()) text += "                   (" + backend_reason + ")\n";
  text += format("termination        %s: %s\n", to_string(termination).c_str(), message.c_str());
  text += format("residuals          %d\n", num_residuals);
  text += format("free parameters    %d\n", num_effective_parameters);
  text += format("linear solver      %s (%s)\n", to_string(linear_solver).c_str(),
                 linear_solver_reason.c_str());
  text += format("Jacobian storage   %s\n", jacobian_storage.c_str());
  text += format("initial cost       %.15e\n", initial_cost);
  text += format("final cost         %.15e\n", final_cost);
  text += format("steps              %d accepted, %d rejected\n", num_accepted, num_rejected);
  text += format("preprocessing      %9.4f s\n", preprocessor_time_s);
  text += format("residuals          %9.4f s\n", residual_time_s);
  text += format("Jacobians          %9.4f s\n", jacobian_time_s);
  text += format("linear solver      %9.4f s\n", linear_solver_time_s);
  text += format("total              %9.4f s\n", total_time_s);
  return text;
}

Summary failed_summary(const std::string& backend, const std::string& message) {
  Summary summary;
  summary.termination = Termination::FAILURE;
  summary.backend = backend;
  summary.message = message;
  return summary;
}

Summary nothing_to_adjust(const std::string& backend) {
  Summary summary;
  summary.termination = Termination::CONVERGENCE;
  summary.backend = backend;
  summary.message = "nothing to adjust: the problem has no observations";
  summary.linear_solver = LinearSolverType::DENSE_SCHUR;
  summary.linear_solver_reason = "nothing to solve";
  summary.initial_cost = summary.final_cost = 0.0;
  summary.deterministic = true;
  IterationSummary row;
  row.iteration = 0;
  row.cost = 0.0;
  summary.iterations.push_back(row);
  return summary;
}

std::string to_string(Termination termination) {
  switch (termination) {
    case Termination::NOT_RUN:
      return "not_run";
    case Termination::CONVERGENCE:
      return "convergence";
    case Termination::MAX_ITERATIONS:
      return "max_iterations";
    case Termination::TIME_LIMIT:
      return "time_limit";
    case Termination::USER_STOPPED:
      return "user_stopped";
    case Termination::FAILURE:
      return "failure";
  }
  return "unknown";
}

std::string to_string(LinearSolverType type) {
  switch (type) {
    case LinearSolverType::AUTO:
      return "auto";
    case LinearSolverType::DENSE_NORMAL_CHOLESKY:
      return "dense_normal_cholesky";
    case LinearSolverType::DENSE_SCHUR:
      return "dense_schur";
    case LinearSolverType::SPARSE_SCHUR:
      return "sparse_schur";
    case LinearSolverType::ITERATIVE_SCHUR:
      return "iterative_schur";
  }
  return "unknown";
}

std::string to_string(Preconditioner preconditioner) {
  switch (preconditioner) {
    case Preconditioner::AUTO:
      return "auto";
    case Preconditioner::IDENTITY:
      return "identity";
    case Preconditioner::JACOBI:
      return "jacobi";
    case Preconditioner::SCHUR_JACOBI:
      return "schur_jacobi";
    case Preconditioner::CLUSTER_JACOBI:
      return "cluster_jacobi";
    case Preconditioner::CLUSTER_TRIDIAGONAL:
      return "cluster_tridiagonal";
    case Preconditioner::TWO_LEVEL:
      return "two_level";
    case Preconditioner::STALE_FACTOR:
      return "stale_factor";
  }
  return "unknown";
}

}  // namespace raylign
