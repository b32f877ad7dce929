// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/preconditioner.h"
#include "raylign/bundle/native/schur_product.h"
#include "raylign/solver/summary.h"

namespace raylign::native {

/// When conjugate gradients stop.
struct CgLimits {
  double residual_tolerance = 0.1;  ///< ‖r‖ <= tolerance ‖b‖, both in the norm of M⁻¹
  double model_tolerance = 0.1;     ///< i (Q_i − Q_{i−1}) <= tolerance Q_i. Nash & Sofer 1990
  int max_num_iterations = 500;
};

struct CgResult {
  bool solved = false;  ///< false: S or the preconditioner is not positive definite, or not finite
  bool interrupted = false;
  int iterations = 0;
};

/// Preconditioned conjugate gradients on S x = b from x = 0 (Hestenes & Stiefel 1952). Nothing is
/// allocated after construction.
class ConjugateGradients {
 public:
  /// @param size  of the vectors
  explicit ConjugateGradients(std::size_t size);

  CgResult solve(SchurProduct& S,
                 SchurPreconditioner& M,
                 const std::vector<double>& b,
                 const CgLimits& limits,
                 const InterruptCheck& interrupted,
                 std::vector<double>& x);

  /// ‖b‖ in the norm of M⁻¹.
  double norm(SchurPreconditioner& M, const std::vector<double>& b);

 private:
  std::vector<double> r_, z_, p_, q_;
};

}  // namespace raylign::native
