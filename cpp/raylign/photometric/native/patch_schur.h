// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/photometric/native/patch_kernels.h"

/// Elimination of the points: plain C over raw arrays, as patch_kernels.h.
namespace raylign::native {

/// L⁻¹, L Lᵀ = H + λ D, as (00, 10, 11, 20, 21, 22); zero for a point that is held. Inverse depth
/// uses the first.
struct PointFactor {
  double values[6];
};

/// What elimination reads of a problem.
struct SchurArrays {
  int num_columns;  ///< C of an image
  int point_size;   ///< 3, inverse depth: 1
  const std::int64_t* slot_starts;
  const std::int32_t* slot_images;
  const double* W;  ///< (slots, 3, C)
  const PointBlock* points;
  const PointFactor* factors;
  const std::int64_t* block_starts;
};

/// Factors of points [begin, end): `damping` (N, 3) is λ D; `held` may be null.
void factor_points(const PointBlock* points,
                   const double* damping,
                   const unsigned char* held,
                   int point_size,
                   std::int64_t begin,
                   std::int64_t end,
                   PointFactor* factors);

/// S −= Σ Wᵀ (H + λD)⁻¹ W and rhs += Σ Wᵀ (H + λD)⁻¹ g over points [begin, end). S: upper block
/// triangle, (blocks, C, C).
void eliminate_points(
    const SchurArrays& arrays, std::int64_t begin, std::int64_t end, double* S, double* rhs);

/// What a step of the points does, summed.
struct PointStep {
  double model_decrease = 0.0;  ///< −gᵀδ − δᵀWδ_c − ½ δᵀHδ, without damping
  double squared_step = 0.0;
  double squared_state = 0.0;
};

/// δ = −(H + λD)⁻¹ (g + W δ_c) of points [begin, end); `images`: (M, C) steps; X (N, 3) moves to
/// X_trial.
PointStep step_points(const SchurArrays& arrays,
                      const double* images,
                      const double* X,
                      std::int64_t begin,
                      std::int64_t end,
                      double* X_trial);

}  // namespace raylign::native
