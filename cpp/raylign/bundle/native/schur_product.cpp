// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_product.h"

#include <algorithm>

namespace raylign::native {
namespace {

constexpr std::int64_t kMaxChunks = 16;
constexpr std::int64_t kMinBlocksPerChunk = 1024;

}  // namespace

ExplicitProduct::ExplicitProduct(const SolverContext& context, const SchurPattern& pattern)
    : pool_(context.pool) {
  const std::int64_t num_chunks =
      std::clamp<std::int64_t>(pattern.num_blocks() / kMinBlocksPerChunk, 1, kMaxChunks);
  for (std::int64_t g = 0; g <= num_chunks; ++g) {
    const std::int64_t target = pattern.num_blocks() * g / num_chunks;
    const auto cut = std::lower_bound(pattern.starts.begin(), pattern.starts.end(), target);
    chunks_.push_back(static_cast<std::int32_t>(cut - pattern.starts.begin()));
  }
  chunks_.back() = pattern.num_cameras();
  for (std::int64_t g = 0; g < num_chunks; ++g) {
    sums_.emplace_back(static_cast<std::size_t>(pattern.num_cameras() - chunks_[g]) * kRow);
  }
}

void ExplicitProduct::prepare(const SchurSystem& system, const DampedProblem&) {
  system_ = &system;
}

void ExplicitProduct::multiply(const double* x, double* y) {
  const SchurPattern& pattern = system_->pattern();
  const auto num_chunks = static_cast<int>(sums_.size());
  pool_.run(num_chunks, [&](int g) {
    std::fill(sums_[g].begin(), sums_[g].end(), 0.0);
    multiply_rows(pattern.starts.data(), pattern.columns.data(), system_->blocks().data(),
                  chunks_[g], chunks_[g + 1], x, sums_[g].data());
  });
  std::copy(sums_[0].begin(), sums_[0].end(), y);
  for (int g = 1; g < num_chunks; ++g) {
    double* rows = y + std::int64_t{chunks_[g]} * kRow;
    for (std::size_t k = 0; k < sums_[g].size(); ++k) rows[k] += sums_[g][k];
  }
}

MatrixFreeProduct::MatrixFreeProduct(const SolverContext& context) : context_(context) {
  const auto rows = static_cast<std::size_t>(context.layout.num_cameras) * kRow;
  const auto num_chunks = static_cast<std::size_t>(context.layout.num_chunks());
  canonical_.resize(rows);
  sums_.assign(num_chunks, std::vector<double>(rows));
  scratch_.assign(num_chunks, Table<ProductScratch>(context.layout.max_track_length()));
}

void MatrixFreeProduct::prepare(const SchurSystem&, const DampedProblem& problem) {
  problem_ = problem;
}

void MatrixFreeProduct::multiply(const double* x, double* y) {
  const Layout& layout = context_.layout;
  const CameraBlocks& cameras = context_.cameras;
  for (std::int64_t i = 0; i < layout.num_cameras; ++i) {
    if (cameras.size(static_cast<int>(i)) == 0) continue;  // its row stays zero
    multiply_block(cameras.map(static_cast<int>(i)), x + i * kRow, canonical_.data() + i * kRow);
  }
  context_.pool.run(layout.num_chunks(), [&](int g) {
    std::fill(sums_[g].begin(), sums_[g].end(), 0.0);
    multiply_landmarks(problem_, layout.chunks[g], layout.chunks[g + 1], canonical_.data(),
                       sums_[g].data(), scratch_[g].data());
  });
  for (std::size_t g = 1; g < sums_.size(); ++g) {
    for (std::size_t k = 0; k < sums_[0].size(); ++k) sums_[0][k] += sums_[g][k];
  }
  for (int i = 0; i < layout.num_cameras; ++i) {
    const double* B = cameras.map(i).values;
    const double* sum = sums_[0].data() + std::int64_t{i} * kRow;
    const double* x_i = x + std::int64_t{i} * kRow;
    double* y_i = y + std::int64_t{i} * kRow;
    std::fill_n(y_i, kRow, 0.0);
    for (int a = 0; a < cameras.size(i); ++a) {
      y_i[a] = problem_.damping[cameras.offset(i) + a] * x_i[a];
      for (int m = 0; m < 9; ++m) y_i[a] += B[m * kRow + a] * sum[m];
    }
  }
}

}  // namespace raylign::native
