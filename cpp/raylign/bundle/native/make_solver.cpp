// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/make_solver.h"

#include <cstdio>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/bundle/native/dense_cholesky.h"
#include "raylign/bundle/native/iterative_solver.h"
#include "raylign/bundle/native/sparse_cholesky.h"
#include "raylign/bundle/native/stale_factor.h"
#include "raylign/bundle/native/two_level.h"
#include "raylign/solver/summary.h"

namespace raylign::native {
namespace {

// Small supernodes run at a third of the speed of one dense matrix.
constexpr double kSparseHandicap = 3.0;

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
  auto preconditioner = make_preconditioner(options.preconditioner, context, pattern);
  return std::make_unique<IterativeSolver>(context, std::move(pattern), std::move(product),
                                           std::move(preconditioner), options, interrupted);
}

std::string direct_reason(LinearSolverType type,
                          const Layout& layout,
                          const SparseOrdering& ordering,
                          double dense_flops) {
  char reason[200];
  if (type == LinearSolverType::SPARSE_SCHUR) {
    std::snprintf(reason, sizeof(reason),
                  "auto: %d cameras, sparse Cholesky of S predicted %.3g GF (%s) against dense "
                  "%.3g GF",
                  layout.num_cameras, ordering.flops / 1e9, ordering.method, dense_flops / 1e9);
  } else {
    std::snprintf(reason, sizeof(reason),
                  "auto: %d cameras, dense Cholesky of S predicted %.3g GF, sparse no less than a "
                  "third of it",
                  layout.num_cameras, dense_flops / 1e9);
  }
  return reason;
}

}  // namespace

void check_linear_solver(const LinearSolverOptions& options) {
  const LinearSolverType type = options.type;
  if (type == LinearSolverType::DENSE_NORMAL_CHOLESKY) {
    throw OptionsError(
        "LinearSolverOptions.type with backend NATIVE must be one of AUTO, DENSE_SCHUR, "
        "SPARSE_SCHUR, ITERATIVE_SCHUR, got dense_normal_cholesky; backend CERES has it");
  }
  if (type == LinearSolverType::SPARSE_SCHUR) require_sparse_cholesky();
  if (type != LinearSolverType::ITERATIVE_SCHUR) return;
  const Preconditioner kind = options.preconditioner;
  if (kind == Preconditioner::CLUSTER_JACOBI || kind == Preconditioner::CLUSTER_TRIDIAGONAL) {
    throw OptionsError("LinearSolverOptions.preconditioner " + to_string(kind) +
                       " is backend CERES's; backend NATIVE has two_level for the same problems");
  }
  const bool needs_S = kind == Preconditioner::TWO_LEVEL || kind == Preconditioner::STALE_FACTOR;
  if (needs_S && !options.explicit_schur) {
    throw OptionsError("LinearSolverOptions.preconditioner " + to_string(kind) +
                       " needs explicit_schur=True: it is made from the blocks of S");
  }
}

ChosenSolver make_linear_solver(const LinearSolverOptions& options,
                                const SolverContext& context,
                                const InterruptCheck& interrupted) {
  auto moving = moving_cameras(context.cameras);
  if (options.type == LinearSolverType::ITERATIVE_SCHUR && !options.explicit_schur) {
    return {make_iterative(options, context, SchurPattern::diagonal(moving), interrupted),
            "requested"};
  }
  SchurPattern pattern(context.layout, moving);
  if (options.type == LinearSolverType::ITERATIVE_SCHUR) {
    return {make_iterative(options, context, std::move(pattern), interrupted), "requested"};
  }
  const bool is_auto = options.type == LinearSolverType::AUTO;
  SparseOrdering ordering;
  LinearSolverType type = options.type;
  if (type != LinearSolverType::DENSE_SCHUR) ordering = order_cameras(pattern);
  const double n = context.cameras.num_columns();
  const double dense_flops = n * n * n / 3.0;
  if (is_auto) {
    const bool sparse = has_sparse_cholesky() && kSparseHandicap * ordering.flops < dense_flops;
    type = sparse ? LinearSolverType::SPARSE_SCHUR : LinearSolverType::DENSE_SCHUR;
  }
  std::unique_ptr<SchurFactor> factor;
  if (type == LinearSolverType::SPARSE_SCHUR) {
    factor = make_sparse_cholesky(context.cameras, pattern, ordering);
  } else {
    factor = std::make_unique<DenseCholesky>(context.cameras, context.pool);
  }
  auto solver =
      std::make_unique<DirectSolver>(type, context, std::move(pattern), std::move(factor));
  if (!is_auto) return {std::move(solver), "requested"};
  return {std::move(solver), direct_reason(type, context.layout, ordering, dense_flops)};
}

}  // namespace raylign::native
