// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/bundle/native/kernels.h"

namespace raylign::native {

/// y += the part of S x that block rows [row_begin, row_end) of the upper triangle and their mirror
/// images make. x: (C, kRow); y: (C − row_begin, kRow), for such rows touch no camera before them.
void multiply_rows(const std::int64_t* starts,
                   const std::int32_t* columns,
                   const Block* blocks,
                   std::int32_t row_begin,
                   std::int32_t row_end,
                   const double* x,
                   double* y);

/// What one step along four tracks leaves for the way back.
struct alignas(32) ProductScratch {
  double values[92];
};

/// y += Σ Fᵀ(F x − A W Wᵀ Σ Aᵀ F x) over landmarks [begin, end): their part of S x, undamped, S not
/// formed. x and y: (C, kRow), canonical tangent. `scratch`: (max_track_length,).
void multiply_landmarks(const DampedProblem& problem,
                        std::int64_t begin,
                        std::int64_t end,
                        const double* x,
                        double* y,
                        ProductScratch* scratch);

/// y = B x for one block.
void multiply_block(const Block& B, const double* x, double* y);

}  // namespace raylign::native
