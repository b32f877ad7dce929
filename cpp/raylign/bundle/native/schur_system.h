// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/bundle/native/product_plan.h"
#include "raylign/bundle/native/schur_kernels.h"
#include "raylign/bundle/native/schur_pattern.h"

namespace raylign::native {

/// The reduced camera system S δ = b after the landmarks are eliminated: the block-sparse upper
/// triangle of S, summed in the canonical tangent and folded by the cameras' maps into the user's.
/// A camera with fewer than nine free columns uses the first ones of its rows; the rest is zero.
/// All memory is taken at construction.
class SchurSystem {
 public:
  SchurSystem(const Layout& layout, const CameraBlocks& cameras, int num_threads);

  /// Forms S and b. `sums`: H and g of each camera; `damping`: added to the diagonal of S,
  /// (num_columns(),).
  void form(const CameraPacket* packets,
            const double* X,
            const ObservationJacobian* J,
            const LandmarkBlock* blocks,
            const LandmarkFactor* factors,
            const std::vector<CameraSums>& sums,
            const std::vector<double>& damping,
            ThreadPool& pool);

  const SchurPattern& pattern() const { return pattern_; }
  const std::vector<Block>& blocks() const { return blocks_; }  ///< of pattern(), user's tangent
  const std::vector<double>& rhs() const { return rhs_; }       ///< b, (C, kRow)
  const CameraBlocks& cameras() const { return cameras_; }

  /// b as one vector (num_columns(),).
  void copy_rhs(double* out) const;

 private:
  void split_rows(int num_parts);
  void set_cameras(const std::vector<CameraSums>& sums, std::int32_t begin, std::int32_t end);
  void fold_rows(const std::vector<double>& damping, std::int32_t begin, std::int32_t end);

  const Layout& layout_;
  const CameraBlocks& cameras_;
  SchurPattern pattern_;
  ProductPlan plan_;
  std::vector<Block> blocks_;
  std::vector<double> rhs_;
  std::vector<std::int32_t> row_parts_;
  std::vector<std::vector<Elimination>> scratch_;
};

}  // namespace raylign::native
