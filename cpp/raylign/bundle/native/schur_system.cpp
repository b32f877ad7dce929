// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_system.h"

#include <algorithm>
#include <cmath>

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotrs_(const char* uplo,
             const int* n,
             const int* nrhs,
             const double* a,
             const int* lda,
             double* b,
             const int* ldb,
             int* info);
}

namespace raylign::native {

SchurSystem::SchurSystem(const Layout& layout, const CameraBlocks& cameras, int num_threads)
    : layout_(layout), cameras_(cameras) {
  const std::int64_t count = cameras.num_cameras();
  for (int i = 0; i < cameras.num_cameras(); ++i) active_.push_back(cameras.size(i) > 0 ? 1 : 0);
  find_blocks();
  split_rows(num_threads);
  rhs_.resize(count * kRow);
  const std::int64_t track = layout.max_track_length();
  scratch_.assign(num_threads, std::vector<Elimination>(track));
  ids_.assign(num_threads, std::vector<std::int32_t>(track));
  const std::size_t n = cameras.num_columns();
  dense_.resize(n * n);
  dense_rhs_.resize(n);
}

void SchurSystem::find_blocks() {
  const std::int64_t count = layout_.num_cameras;
  index_.assign(count * count, -1);
  constexpr std::int64_t kWanted = 0;
  for (std::int64_t j = 0; j < layout_.num_landmarks(); ++j) {
    for (auto q = layout_.starts[j]; q < layout_.starts[j + 1]; ++q) {
      const std::int64_t i = layout_.camera[q];
      if (active_[i] == 0) continue;
      for (auto k = q; k < layout_.starts[j + 1]; ++k) {
        if (active_[layout_.camera[k]] != 0) index_[i * count + layout_.camera[k]] = kWanted;
      }
    }
  }
  std::int64_t num_blocks = 0;
  for (std::int64_t& block : index_) {
    if (block == kWanted) block = num_blocks++;
  }
  blocks_.resize(num_blocks);
}

// Cuts the block rows so that each part has about the same number of products.
void SchurSystem::split_rows(int num_parts) {
  std::vector<std::int64_t> products(layout_.num_cameras + 1, 0);
  for (std::int64_t j = 0; j < layout_.num_landmarks(); ++j) {
    for (auto q = layout_.starts[j]; q < layout_.starts[j + 1]; ++q) {
      products[layout_.camera[q] + 1] += layout_.starts[j + 1] - q;
    }
  }
  for (std::int32_t i = 0; i < layout_.num_cameras; ++i) products[i + 1] += products[i];
  for (int part = 0; part <= num_parts; ++part) {
    const std::int64_t target = products.back() * part / num_parts;
    const auto cut = std::lower_bound(products.begin(), products.end(), target);
    row_parts_.push_back(static_cast<std::int32_t>(cut - products.begin()));
  }
  row_parts_.back() = layout_.num_cameras;
}

void SchurSystem::form(const CameraPacket* packets,
                       const double* X,
                       const ObservationJacobian* J,
                       const LandmarkBlock* blocks,
                       const LandmarkFactor* factors,
                       const std::vector<CameraSums>& sums,
                       const std::vector<double>& damping,
                       ThreadPool& pool) {
  const Observations observations{layout_.starts.data(), layout_.camera.data(), layout_.uv.data()};
  const SchurBlocks S{layout_.num_cameras, index_.data(), active_.data(), blocks_.data(),
                      rhs_.data()};
  pool.run(static_cast<int>(row_parts_.size()) - 1, [&](int part) {
    const std::int32_t begin = row_parts_[part];
    const std::int32_t end = row_parts_[part + 1];
    set_cameras(sums, begin, end);
    subtract_landmarks(observations, layout_.num_landmarks(), packets, X, J, blocks, factors, begin,
                       end, S, scratch_[part].data(), ids_[part].data());
    fold_rows(damping, begin, end);
  });
}

// S = U on the diagonal, b = −g; the landmarks come on top.
void SchurSystem::set_cameras(const std::vector<CameraSums>& sums,
                              std::int32_t begin,
                              std::int32_t end) {
  const std::int64_t count = layout_.num_cameras;
  for (std::int64_t i = begin; i < end; ++i) {
    for (std::int64_t k = i; k < count; ++k) {
      const std::int64_t block = index_[i * count + k];
      if (block < 0) continue;
      blocks_[block] = k == i ? sums[i].U : Block{};
    }
    for (int m = 0; m < kRow; ++m) rhs_[i * kRow + m] = -sums[i].g[m];
  }
}

// Block row i of the canonical S becomes the columns of camera i in the dense lower triangle.
void SchurSystem::fold_rows(const std::vector<double>& damping,
                            std::int32_t begin,
                            std::int32_t end) {
  const std::int64_t count = layout_.num_cameras;
  const std::int64_t n = cameras_.num_columns();
  for (std::int32_t i = begin; i < end; ++i) {
    const std::int64_t first = cameras_.offset(i);
    const int size = cameras_.size(i);
    std::fill_n(dense_.begin() + first * n, size * n, 0.0);
    for (std::int32_t k = i; k < count && size > 0; ++k) {
      const std::int64_t block = index_[i * count + k];
      if (block < 0) continue;
      fold_block(blocks_[block], cameras_.map(i), cameras_.map(k), size, cameras_.size(k),
                 dense_.data() + first * n + cameras_.offset(k), n);
    }
    for (int a = 0; a < size; ++a) {
      dense_[(first + a) * n + first + a] += damping[first + a];
      double sum = 0.0;
      for (int m = 0; m < 9; ++m) sum += cameras_.map(i).values[m * kRow + a] * rhs_[i * kRow + m];
      dense_rhs_[first + a] = sum;
    }
  }
}

bool SchurSystem::solve(std::vector<double>& delta) {
  const int n = cameras_.num_columns();
  delta = dense_rhs_;
  if (n == 0) return true;
  const int one = 1;
  int info = 0;
  dpotrf_("L", &n, dense_.data(), &n, &info);
  if (info != 0) return false;
  dpotrs_("L", &n, &one, dense_.data(), &n, delta.data(), &n, &info);
  return info == 0 &&
         std::all_of(delta.begin(), delta.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace raylign::native
