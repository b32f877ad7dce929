// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/bundle/native/product_kernels.h"
#include "raylign/bundle/native/product_plan.h"
#include "raylign/bundle/native/schur_kernels.h"
#include "raylign/bundle/native/schur_pattern.h"
#include "raylign/bundle/native/table.h"

namespace raylign::native {

/// What a linear solver works on and with; outlives it.
struct SolverContext {
  const Layout& layout;
  const CameraBlocks& cameras;
  ThreadPool& pool;
};

/// 1 for cameras with free columns.
std::vector<unsigned char> moving_cameras(const CameraBlocks& cameras);

/// The reduced camera system S δ = b after the landmarks are eliminated: the block-sparse upper
/// triangle of S, summed in the canonical tangent and folded by the cameras' maps into the user's.
/// A camera with fewer than nine free columns uses the first ones of its rows; the rest is zero.
/// All memory is taken at construction.
class SchurSystem {
 public:
  SchurSystem(const SolverContext& context, SchurPattern pattern);

  void form(const DampedProblem& problem);

  const SchurPattern& pattern() const { return pattern_; }
  const ProductPlan& plan() const { return plan_; }
  const Table<Block>& blocks() const { return blocks_; }   ///< of pattern(), user's tangent
  const std::vector<double>& rhs() const { return rhs_; }  ///< b, (C, kRow)
  const CameraBlocks& cameras() const { return context_.cameras; }
  /// Block `diagonal(i)` of a moving camera.
  const Block& diagonal(int i) const { return blocks_[pattern_.starts[i]]; }

 private:
  void split_rows(int num_parts);
  void set_cameras(const CameraSums* sums, std::int32_t begin, std::int32_t end);
  void fold_rows(const double* damping, std::int32_t begin, std::int32_t end);

  SolverContext context_;
  SchurPattern pattern_;
  ProductPlan plan_;
  Table<Block> blocks_;
  std::vector<double> rhs_;
  std::vector<std::int32_t> row_parts_;
  std::vector<Table<Elimination>> scratch_;
};

/// From rows of kRow per camera to one vector over the free columns, and back (zeros elsewhere).
void pack(const CameraBlocks& cameras, const double* rows, double* columns);
void unpack(const CameraBlocks& cameras, const double* columns, double* rows);

}  // namespace raylign::native
