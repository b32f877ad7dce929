// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

namespace raylign {

/// Options of the Levenberg-Marquardt loop. One set of names in every engine, in Python and on the
/// command line. λ is the damping factor: (JᵀJ + λ diag(JᵀJ)) δ = −Jᵀr; Ceres' trust-region radius
/// is 1/λ.
struct LmOptions {
  int max_num_iterations = 50;  ///< Outer iterations, >= 0; 0 only evaluates the cost.
  double max_solver_time_s = std::numeric_limits<double>::infinity();  ///< Wall time in s, > 0.
  double function_tolerance = 1e-6;   ///< Stop when |cost change| <= tolerance · cost; >= 0.
  double gradient_tolerance = 1e-10;  ///< Stop when max |gradient| <= tolerance; >= 0.
  double parameter_tolerance = 1e-8;  ///< Stop when ‖δ‖ <= tolerance · (‖x‖ + tolerance); >= 0.
  double initial_lambda = 1e-4;       ///< Damping of the first step, > 0. Nielsen 1999.
  double min_lambda = 1e-16;          ///< Lower bound of λ, > 0.
  double max_lambda = 1e32;           ///< Give up when λ grows past it; > min_lambda.
  double min_relative_decrease =
      1e-3;                    ///< Accept a step when actual/predicted decrease exceeds it; [0, 1).
  double min_diagonal = 1e-6;  ///< Clamp of diag(JᵀJ) from below, > 0. Ceres min_lm_diagonal.
  double max_diagonal = 1e32;  ///< Clamp from above, >= min_diagonal.
  int max_num_consecutive_invalid_steps =
      5;                       ///< Steps without a finite trial before FAILURE; >= 1.
  bool jacobi_scaling = true;  ///< Scale columns of J by 1 / (1 + ‖column‖) once, at the start.
  int num_threads = 1;         ///< >= 1.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

enum class LinearSolverType {
  AUTO,                   ///< chosen from the problem's size; summary.linear_solver_reason says why
  DENSE_NORMAL_CHOLESKY,  ///< JᵀJ as one dense matrix: what "bundle adjustment is slow" means
  DENSE_SCHUR,            ///< points eliminated, dense Cholesky of S
  SPARSE_SCHUR,           ///< points eliminated, sparse Cholesky of S
  ITERATIVE_SCHUR,        ///< points eliminated, preconditioned conjugate gradients on S
};

enum class Preconditioner {
  AUTO,  ///< TWO_LEVEL where NATIVE forms S, else SCHUR_JACOBI
  IDENTITY,
  JACOBI,               ///< block diagonal of H_pp
  SCHUR_JACOBI,         ///< block diagonal of S
  CLUSTER_JACOBI,       ///< S of camera clusters by visibility; CERES. Kushal & Agarwal 2012.
  CLUSTER_TRIDIAGONAL,  ///< the same with a tree of neighbouring clusters; CERES
  TWO_LEVEL,            ///< SCHUR_JACOBI plus similarity motions of camera clusters; NATIVE
  STALE_FACTOR,         ///< Cholesky factor of an earlier S; NATIVE
};

/// How (H + λD) δ = −g is solved.
struct LinearSolverOptions {
  LinearSolverType type = LinearSolverType::AUTO;
  Preconditioner preconditioner = Preconditioner::AUTO;  ///< ITERATIVE_SCHUR only.
  bool explicit_schur = false;   ///< ITERATIVE_SCHUR: form S instead of applying it. TWO_LEVEL and
                                 ///< STALE_FACTOR need it; with CERES only SCHUR_JACOBI has it.
  int max_num_iterations = 500;  ///< Conjugate-gradient iterations per step, >= 1.
  double forcing_tolerance =
      0.1;  ///< η of the inexact step, in (0, 1). Nash & Sofer 1990; Ceres eta.

  void validate() const;
};

}  // namespace raylign
