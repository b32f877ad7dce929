// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/bundle/native/kernels.h"

namespace raylign::native {

/// Zᵀ of one observation: three rows of eight, and the ninth of each row.
struct alignas(64) Elimination {
  double Z[3][8];
  double tail[4];  ///< tail[3] = 0
};

/// Two observations of a landmark, as places in their window.
struct Product {
  std::uint16_t i, k;
};

/// The products of a window that fall into one block of S; they begin where those of the visit
/// before end.
struct BlockVisit {
  std::int32_t row;
  std::int32_t block;
  std::int32_t products_end;  ///< counted from the window's first
};

/// Landmarks whose Z are written down together; see ProductPlan.
struct ProductWindow {
  std::int64_t landmark_begin, landmark_end;
  std::int64_t visits_begin, visits_end;
  std::int64_t products_begin;
  bool is_planned;  ///< else: one landmark, whose blocks are searched
};

struct ProductWindows {
  std::int64_t count;
  const ProductWindow* windows;
  const BlockVisit* visits;
  const Product* products;
};

/// The block-sparse upper triangle of S, in the canonical tangent; see SchurPattern.
struct SchurBlocks {
  const unsigned char* active;
  const std::int64_t* starts;
  const std::int32_t* columns;
  Block* blocks;
  double* rhs;                 ///< (C, kRow)
  bool diagonal_only = false;  ///< there are no other blocks
};

/// Block rows [begin, end).
struct RowRange {
  std::int32_t begin, end;
};

/// The given rows of S −= Σ Z Zᵀ and rhs += Σ Z Wᵀg over all landmarks, Z = Fᵀ E W. Each block is
/// summed window after window and there in the order of the landmarks, whatever the rows of the
/// call. `scratch`: (Layout::max_window(),), one per thread.
void subtract_landmarks(const DampedProblem& problem,
                        const ProductWindows& plan,
                        RowRange rows,
                        const SchurBlocks& S,
                        Elimination* scratch);

/// The two bodies of `subtract_landmarks`, by the width of their vectors, for the tests; it takes
/// the one that the machine runs faster.
using SubtractLandmarks = decltype(subtract_landmarks);
SubtractLandmarks* narrow_subtract_landmarks();
SubtractLandmarks* wide_subtract_landmarks();  ///< null where there is no AVX-512

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
