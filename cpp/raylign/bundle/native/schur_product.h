// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/schur_system.h"

namespace raylign::native {

/// y = S x for rows of kRow per camera, S of the last `prepare`. Sums are cut by the problem alone,
/// never by the number of threads.
class SchurProduct {
 public:
  virtual ~SchurProduct() = default;
  /// `system`: formed from `problem`.
  virtual void prepare(const SchurSystem& system, const DampedProblem& problem) = 0;
  virtual void multiply(const double* x, double* y) = 0;
};

/// By the blocks of S: each is read once, for itself and its mirror image.
class ExplicitProduct : public SchurProduct {
 public:
  ExplicitProduct(const SolverContext& context, const SchurPattern& pattern);
  void prepare(const SchurSystem& system, const DampedProblem& problem) override;
  void multiply(const double* x, double* y) override;

 private:
  ThreadPool& pool_;
  const SchurSystem* system_ = nullptr;
  std::vector<std::int32_t> chunks_;       // (G + 1,) rows
  std::vector<std::vector<double>> sums_;  // (G,) of (C − first row, kRow)
};

/// By the landmarks, S not formed: one pass over the data.
class MatrixFreeProduct : public SchurProduct {
 public:
  explicit MatrixFreeProduct(const SolverContext& context);
  void prepare(const SchurSystem& system, const DampedProblem& problem) override;
  void multiply(const double* x, double* y) override;

 private:
  SolverContext context_;
  DampedProblem problem_{};
  std::vector<double> canonical_;               // (C, kRow) B x
  std::vector<std::vector<double>> sums_;       // (G,) of (C, kRow)
  std::vector<Table<ProductScratch>> scratch_;  // (G,)
};

}  // namespace raylign::native
