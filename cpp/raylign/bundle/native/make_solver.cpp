// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/make_solver.h"

#include <utility>

#include "raylign/base/error.h"
#include "raylign/bundle/native/auto_solver.h"
#include "raylign/bundle/native/camera_ordering.h"
#include "raylign/bundle/native/dense_cholesky.h"
#include "raylign/bundle/native/iterative_solver.h"
#include "raylign/bundle/native/stale_factor.h"
#include "raylign/bundle/native/supernodal_cholesky.h"
#include "raylign/bundle/native/two_level.h"
#include "raylign/solver/summary.h"

namespace raylign::native {
namespace {

std::unique_ptr<SchurPreconditioner> make_preconditioner(Preconditioner kind,
                                                         const SolverContext& context,
                                                         const SchurPattern& pattern) {
  switch (kind) {
    case Preconditioner::TWO_LEVEL:
      return std::make_unique<TwoLevel>(context, pattern);
    case Preconditioner::STALE_FACTOR:
      return std::make_unique<StaleFactor>(
          context.cameras, std::make_unique<DenseCholesky>(context.cameras, context.pool));
    default:
      return std::make_unique<BlockJacobi>(context.cameras, kind);
  }
}

std::unique_ptr<LinearSolver> make_iterative(const LinearSolverOptions& options,
                                             const SolverContext& context,
                                             SchurPattern pattern,
                                             const InterruptCheck& interrupted) {
  std::unique_ptr<SchurProduct> product;
  if (options.explicit_schur) {
    product = std::make_unique<ExplicitProduct>(context, pattern);
  } else {
    product = std::make_unique<MatrixFreeProduct>(context);
  }
  Preconditioner kind = options.preconditioner;
  if (kind == Preconditioner::AUTO) {
    kind = options.explicit_schur ? Preconditioner::TWO_LEVEL : Preconditioner::SCHUR_JACOBI;
  }
  auto preconditioner = make_preconditioner(kind, context, pattern);
  return std::make_unique<IterativeSolver>(context, std::move(pattern), std::move(product),
                                           std::move(preconditioner), options, interrupted);
}

}  // namespace

std::string missing_linear_solver(const LinearSolverOptions& options) {
  const LinearSolverType type = options.type;
  const Preconditioner kind = options.preconditioner;
  if (type == LinearSolverType::DENSE_NORMAL_CHOLESKY) {
    return "LinearSolverOptions.type with backend NATIVE must be one of AUTO, DENSE_SCHUR, "
           "SPARSE_SCHUR, ITERATIVE_SCHUR, got dense_normal_cholesky; backend CERES has it";
  }
  if (type == LinearSolverType::ITERATIVE_SCHUR &&
      (kind == Preconditioner::CLUSTER_JACOBI || kind == Preconditioner::CLUSTER_TRIDIAGONAL)) {
    return "LinearSolverOptions.preconditioner " + to_string(kind) +
           " is backend CERES's; backend NATIVE has two_level for the same problems";
  }
  return "";
}

void check_linear_solver(const LinearSolverOptions& options) {
  if (options.type != LinearSolverType::ITERATIVE_SCHUR || options.explicit_schur) return;
  const Preconditioner kind = options.preconditioner;
  if (kind == Preconditioner::TWO_LEVEL || kind == Preconditioner::STALE_FACTOR) {
    throw OptionsError("LinearSolverOptions.preconditioner " + to_string(kind) +
                       " needs explicit_schur=True: it is made from the blocks of S");
  }
}

std::unique_ptr<LinearSolver> make_requested_solver(const LinearSolverOptions& options,
                                                    const SolverContext& context,
                                                    const InterruptCheck& interrupted,
                                                    const SchurStructure* known) {
  auto moving = moving_cameras(context.cameras);
  if (options.type == LinearSolverType::ITERATIVE_SCHUR && !options.explicit_schur) {
    return make_iterative(options, context, SchurPattern::diagonal(std::move(moving)), interrupted);
  }
  SchurPattern pattern = known != nullptr
                             ? known->pattern
                             : SchurPattern(context.layout, std::move(moving), context.pool);
  if (options.type == LinearSolverType::ITERATIVE_SCHUR) {
    return make_iterative(options, context, std::move(pattern), interrupted);
  }
  std::unique_ptr<SchurFactor> factor;
  if (options.type == LinearSolverType::SPARSE_SCHUR) {
    auto order = known != nullptr ? known->ordering.cameras : order_cameras(pattern).cameras;
    factor = std::make_unique<SupernodalCholesky>(context.cameras, pattern, std::move(order),
                                                  context.pool);
  } else {
    factor = std::make_unique<DenseCholesky>(context.cameras, context.pool);
  }
  return std::make_unique<DirectSolver>(options.type, context, std::move(pattern),
                                        std::move(factor));
}

std::unique_ptr<LinearSolver> make_linear_solver(const LinearSolverOptions& options,
                                                 const SolverContext& context,
                                                 const InterruptCheck& interrupted) {
  if (options.type == LinearSolverType::AUTO) {
    return std::make_unique<AutoSolver>(options, context, interrupted);
  }
  return make_requested_solver(options, context, interrupted);
}

}  // namespace raylign::native
