// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/bundle/native/kernels.h"

namespace raylign::native {

inline constexpr int kModes = 7;    ///< of a cluster: similarity motions
inline constexpr int kModeRow = 8;  ///< of Z: a row of seven, padded
inline constexpr int kModeSize = 9 * kModeRow;

/// S by block rows (SchurPattern) and the coarse space that it is projected to.
struct CoarseProjection {
  const std::int64_t* starts;
  const std::int32_t* columns;
  const Block* blocks;
  const double* modes;          ///< (C, 9, kModeRow) Z
  const std::int32_t* cluster;  ///< (C,)
};

/// Adds Z_kᵀ S_ikᵀ Z_i for the blocks of row i to rows kModes · cluster[k] of `panel`, (kModes ·
/// clusters, kModeRow), 32-byte aligned; the half of it for the diagonal block.
void project_row(const CoarseProjection& projection, std::int32_t i, double* panel);

}  // namespace raylign::native
