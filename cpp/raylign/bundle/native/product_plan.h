// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/bundle/native/schur_kernels.h"
#include "raylign/bundle/native/schur_pattern.h"
#include "raylign/bundle/native/table.h"

namespace raylign::native {

/// The products Z_i Z_kᵀ of every window of the layout, sorted by the block that they fall into: a
/// block is then read and written once per window and summed in registers. Four bytes a product;
/// the landmarks of tracks too long for that (Layout::kLongTrack) have none and are searched.
struct ProductPlan {
  /// The same for any number of threads.
  ProductPlan(const Layout& layout, const SchurPattern& pattern, ThreadPool& pool);
  /// On the calling thread.
  ProductPlan(const Layout& layout, const SchurPattern& pattern);

  std::vector<ProductWindow> windows;  ///< one per window of the layout
  Table<BlockVisit> visits;            ///< window after window, blocks ascending
  Table<Product> products;             ///< visit after visit, in the order of the landmarks
};

}  // namespace raylign::native
