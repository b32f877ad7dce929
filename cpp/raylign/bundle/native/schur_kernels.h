// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/bundle/native/kernels.h"

namespace raylign::native {

/// Zᵀ of one observation: three rows of kRow.
struct alignas(32) Elimination {
  double Z[3 * kRow];
};

/// The block-sparse upper triangle of S, in the canonical tangent; see SchurPattern.
struct SchurBlocks {
  const unsigned char* active;
  const std::int64_t* starts;
  const std::int32_t* columns;
  const std::uint16_t* places;
  std::int64_t max_tabulated;
  Block* blocks;
  double* rhs;  ///< (C, kRow)
};

/// Block rows [row_begin, row_end) of S −= Σ Z Zᵀ and rhs += Σ Z Wᵀg over all landmarks, Z = Fᵀ A
/// W. Each block is summed in the order of the landmarks, whatever the rows of the call. `scratch`
/// and `ids`: (max_track_length,), one per thread.
void subtract_landmarks(const Observations& observations,
                        std::int64_t num_landmarks,
                        const CameraPacket* packets,
                        const double* X,
                        const ObservationJacobian* J,
                        const LandmarkBlock* blocks,
                        const LandmarkFactor* factors,
                        std::int32_t row_begin,
                        std::int32_t row_end,
                        const SchurBlocks& S,
                        Elimination* scratch,
                        std::int32_t* ids);

/// out[a][b] = (B_iᵀ M B_k)[a][b] for a < rows, b < columns; row a starts at out + a · stride. M
/// and B are blocks.
void fold_block(const Block& M,
                const Block& B_i,
                const Block& B_k,
                int rows,
                int columns,
                double* out,
                std::int64_t stride);

}  // namespace raylign::native
