// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace raylign {

/// A least-squares problem linearised at its current state: r(x ⊞ δ) ≈ r + J δ, with the robust
/// weights applied to r and J (IRLS). Rows: two per observation, in the problem's order. Columns:
/// the tangent of each free block, camera by camera (pose, then intrinsics), then point by point;
/// held coordinates have none.
struct Linearization {
  double cost = -1.0;             ///< ½ Σ ρ(‖r‖²)
  std::vector<double> residuals;  ///< (2N,) weighted
  std::vector<double> gradient;   ///< (n,) Jᵀ r
  std::int64_t num_columns = 0;   ///< n
  /// J in compressed row storage.
  std::vector<std::int32_t> row_starts;  ///< (2N + 1,)
  std::vector<std::int32_t> columns;
  std::vector<double> values;
};

}  // namespace raylign
