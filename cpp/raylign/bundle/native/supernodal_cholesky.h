// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/schur_factor.h"
#include "raylign/bundle/native/supernodes.h"
#include "raylign/bundle/native/table.h"

namespace raylign::native {

/// The multifrontal Cholesky factor of S (Duff & Reid 1983; Liu 1992): each supernode is a dense
/// front, its pivots and the rows below them; what it leaves of the rows, its update, is added to
/// the front of its parent. Subtrees are shared out to the threads, then these share the panels of
/// the fronts on top. Every number is computed by the same calls on any number of threads. All
/// memory is taken at construction.
class SupernodalCholesky : public SchurFactor {
 public:
  /// @param order  the moving cameras in the order of elimination, postordered
  SupernodalCholesky(const CameraBlocks& cameras,
                     const SchurPattern& pattern,
                     std::vector<std::int32_t> order,
                     ThreadPool& pool);
  bool factor(const SchurSystem& system) override;
  void solve(double* x) override;

 private:
  // A block of S in a front.
  struct Entry {
    std::int64_t block;
    int row, column;  // in the front
    int num_rows, num_columns;
    bool transposed;  // stored as (column camera, row camera)
  };
  // Consecutive rows of an update that stay together in the parent's front.
  struct Run {
    int from, to, length;
  };
  struct Front {
    int num_pivots = 0;       // scalar columns
    int num_rows = 0;         // below them
    std::int64_t panel = 0;   // (num_pivots + num_rows, num_pivots), column-major, in L_
    std::int64_t update = 0;  // lower triangle by strips of columns, in updates_
    std::vector<Entry> entries;
    std::vector<Run> runs;  // of the update, into the parent
    std::vector<std::int32_t> children;
    int height() const { return num_pivots + num_rows; }
  };

  void measure_fronts();
  void find_entries(const SchurPattern& pattern);
  void find_runs();
  void place_updates();

  double* panel(std::int32_t n) { return L_.data() + fronts_[n].panel; }
  double* update_column(std::int32_t n, int column);
  void assemble(std::int32_t n, const SchurSystem& system);
  void add_child(std::int32_t child, std::int32_t parent);
  template <typename Run>
  bool eliminate(std::int32_t n, const Run& run);

  const CameraBlocks& cameras_;
  ThreadPool& pool_;
  std::vector<std::int32_t> order_;
  std::vector<int> offsets_;  // first scalar column of each position
  SupernodeTree tree_;
  std::vector<Front> fronts_;  // of each supernode
  Table<double> L_, updates_;
  std::vector<unsigned char> subtree_is_definite_;
  std::vector<double> x_, work_;
};

}  // namespace raylign::native
