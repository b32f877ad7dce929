// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/layout.h"

namespace raylign::native {

/// Which blocks the reduced camera system S has: the upper triangle by block rows. Found
/// once; no table is C × C.
struct SchurPattern {
  /// The same for any number of threads.
  /// @param active  (C,) 0: the camera does not move, S has no row for it
  SchurPattern(const Layout& layout, std::vector<unsigned char> active, ThreadPool& pool);
  /// On the calling thread.
  SchurPattern(const Layout& layout, std::vector<unsigned char> active);
  /// The diagonal blocks alone: what a matrix-free product needs for its preconditioner.
  static SchurPattern diagonal(std::vector<unsigned char> active);

  std::vector<unsigned char> active;
  std::vector<std::int64_t> starts;   ///< (C + 1,) first block of each row
  std::vector<std::int32_t> columns;  ///< (num_blocks,) ascending in a row, the diagonal first

  bool diagonal_only = false;
  std::int64_t num_pairs = 0;  ///< of moving cameras: products Z Zᵀ in one formation of S

  std::int32_t num_cameras() const { return static_cast<std::int32_t>(active.size()); }
  std::int64_t num_blocks() const { return static_cast<std::int64_t>(columns.size()); }

  /// Block (i, k), i <= k, which must exist.
  std::int32_t find(std::int32_t i, std::int32_t k) const;

 private:
  SchurPattern() = default;
};

}  // namespace raylign::native
