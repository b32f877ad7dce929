// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/schur_system.h"
#include "raylign/solver/options.h"

namespace raylign::native {

/// M⁻¹ ≈ S⁻¹, symmetric and positive definite, for rows of kRow per camera.
class SchurPreconditioner {
 public:
  virtual ~SchurPreconditioner() = default;
  /// `system`: formed from `problem`.
  virtual void prepare(const SchurSystem& system, const DampedProblem& problem) = 0;
  virtual void apply(const double* r, double* z) = 0;
  /// Told how many iterations the last system took.
  virtual void report(int iterations) { static_cast<void>(iterations); }
};

/// The inverses of one 9×9 block per camera: of S (SCHUR_JACOBI), of U + λD (JACOBI), or none
/// (IDENTITY). A block of S that rounding made indefinite is replaced by U + λD.
class BlockJacobi : public SchurPreconditioner {
 public:
  BlockJacobi(const CameraBlocks& cameras, Preconditioner kind);
  void prepare(const SchurSystem& system, const DampedProblem& problem) override;
  void apply(const double* r, double* z) override;

 private:
  bool invert(int i, const Block& block);

  const CameraBlocks& cameras_;
  Preconditioner kind_;
  std::vector<Block> inverses_;
};

}  // namespace raylign::native
