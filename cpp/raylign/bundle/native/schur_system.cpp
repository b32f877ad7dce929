// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_system.h"

#include <algorithm>
#include <utility>

namespace raylign::native {

std::vector<unsigned char> moving_cameras(const CameraBlocks& cameras) {
  std::vector<unsigned char> moving;
  for (int i = 0; i < cameras.num_cameras(); ++i) moving.push_back(cameras.size(i) > 0 ? 1 : 0);
  return moving;
}

SchurSystem::SchurSystem(const SolverContext& context, SchurPattern pattern)
    : context_(context),
      pattern_(std::move(pattern)),
      plan_(context.layout, pattern_, context.pool) {
  const int num_threads = context.pool.num_threads();
  split_rows(num_threads);
  blocks_.resize(pattern_.num_blocks());
  rhs_.resize(static_cast<std::size_t>(pattern_.num_cameras()) * kRow);
  scratch_.assign(num_threads, Table<Elimination>(context.layout.max_window()));
}

// Cuts the block rows so that each part has about the same number of products.
void SchurSystem::split_rows(int num_parts) {
  const Layout& layout = context_.layout;
  std::vector<std::int64_t> products(layout.num_cameras + 1, 0);
  for (const ProductWindow& window : plan_.windows) {
    std::int32_t before = 0;
    for (auto v = window.visits_begin; v < window.visits_end; ++v) {
      const BlockVisit& visit = plan_.visits[v];
      products[visit.row + 1] += visit.products_end - std::exchange(before, visit.products_end);
    }
    if (window.is_planned) continue;
    const std::int64_t end = layout.starts[window.landmark_end];
    for (auto q = layout.starts[window.landmark_begin]; q < end; ++q) {
      products[layout.camera[q] + 1] += pattern_.diagonal_only ? 1 : end - q;
    }
  }
  for (std::int32_t i = 0; i < layout.num_cameras; ++i) products[i + 1] += products[i];
  for (int part = 0; part <= num_parts; ++part) {
    const std::int64_t target = products.back() * part / num_parts;
    const auto cut = std::lower_bound(products.begin(), products.end(), target);
    row_parts_.push_back(static_cast<std::int32_t>(cut - products.begin()));
  }
  row_parts_.back() = layout.num_cameras;
}

void SchurSystem::form(const DampedProblem& problem) {
  const SchurBlocks S{pattern_.active.data(),
                      pattern_.starts.data(),
                      pattern_.columns.data(),
                      blocks_.data(),
                      rhs_.data(),
                      pattern_.diagonal_only};
  const ProductWindows plan{static_cast<std::int64_t>(plan_.windows.size()), plan_.windows.data(),
                            plan_.visits.data(), plan_.products.data()};
  context_.pool.run(static_cast<int>(row_parts_.size()) - 1, [&](int part) {
    const std::int32_t begin = row_parts_[part];
    const std::int32_t end = row_parts_[part + 1];
    set_cameras(problem.cameras, begin, end);
    subtract_landmarks(problem, plan, {begin, end}, S, scratch_[part].data());
    fold_rows(problem.damping, begin, end);
  });
}

// S = U on the diagonal, b = −g; the landmarks come on top.
void SchurSystem::set_cameras(const CameraSums* sums, std::int32_t begin, std::int32_t end) {
  for (std::int32_t i = begin; i < end; ++i) {
    const std::int64_t first = pattern_.starts[i];
    std::fill(blocks_.begin() + first, blocks_.begin() + pattern_.starts[i + 1], Block{});
    if (pattern_.active[i] == 0) continue;
    blocks_[first] = sums[i].U;
    for (int m = 0; m < kRow; ++m) rhs_[std::int64_t{i} * kRow + m] = -sums[i].g[m];
  }
}

// From the canonical tangent to the user's: Bᵢᵀ S Bₖ + λD and Bᵢᵀ b.
void SchurSystem::fold_rows(const double* damping, std::int32_t begin, std::int32_t end) {
  const CameraBlocks& cameras = context_.cameras;
  for (std::int32_t i = begin; i < end; ++i) {
    if (pattern_.active[i] == 0) continue;
    const Block& B = cameras.map(i);
    for (auto b = pattern_.starts[i]; b < pattern_.starts[i + 1]; ++b) {
      double* block = blocks_[b].values;
      fold_block(blocks_[b], B, cameras.map(pattern_.columns[b]), 9, kRow, block, kRow);
    }
    double* diagonal = blocks_[pattern_.starts[i]].values;
    double* rhs = rhs_.data() + std::int64_t{i} * kRow;
    double folded[kRow] = {};
    for (int a = 0; a < cameras.size(i); ++a) {
      diagonal[a * kRow + a] += damping[cameras.offset(i) + a];
      for (int m = 0; m < 9; ++m) folded[a] += B.values[m * kRow + a] * rhs[m];
    }
    std::copy_n(folded, kRow, rhs);
  }
}

void pack(const CameraBlocks& cameras, const double* rows, double* columns) {
  for (int i = 0; i < cameras.num_cameras(); ++i) {
    std::copy_n(rows + std::int64_t{i} * kRow, cameras.size(i), columns + cameras.offset(i));
  }
}

void unpack(const CameraBlocks& cameras, const double* columns, double* rows) {
  for (int i = 0; i < cameras.num_cameras(); ++i) {
    double* row = rows + std::int64_t{i} * kRow;
    std::fill_n(row, kRow, 0.0);
    std::copy_n(columns + cameras.offset(i), cameras.size(i), row);
  }
}

}  // namespace raylign::native
