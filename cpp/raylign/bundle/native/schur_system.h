// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/layout.h"

namespace raylign::native {

/// The reduced camera system S δ = b after the landmarks are eliminated: summed as 9×9 blocks in
/// the canonical tangent, folded by the cameras' maps into one dense matrix over the user's free
/// columns, factored by LAPACK. All memory is taken at construction.
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
  /// δ (num_columns(),) in the user's tangent; false when S is not positive definite.
  bool solve(std::vector<double>& delta);

  /// Lower triangle, column-major, (n, n); what stands above the diagonal blocks is not defined.
  const std::vector<double>& matrix() const { return dense_; }
  const std::vector<double>& rhs() const { return dense_rhs_; }

 private:
  void find_blocks();
  void split_rows(int num_parts);
  void set_cameras(const std::vector<CameraSums>& sums, std::int32_t begin, std::int32_t end);
  void fold_rows(const std::vector<double>& damping, std::int32_t begin, std::int32_t end);

  const Layout& layout_;
  const CameraBlocks& cameras_;
  std::vector<unsigned char> active_;
  std::vector<std::int64_t> index_;  // (C·C,) see SchurBlocks
  std::vector<Block> blocks_;
  std::vector<double> rhs_;
  std::vector<std::int32_t> row_parts_;
  std::vector<std::vector<Elimination>> scratch_;
  std::vector<std::vector<std::int32_t>> ids_;
  std::vector<double> dense_, dense_rhs_;
};

}  // namespace raylign::native
