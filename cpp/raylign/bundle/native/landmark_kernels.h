// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "raylign/bundle/native/kernels.h"

namespace raylign::native {

/// How landmarks are damped: lm_damping of solver/lm.h. λ clamp(s² h, min, max) / s² is added to
/// each diagonal element h.
struct LandmarkDamping {
  double lambda;
  double min_diagonal;
  double max_diagonal;
  const double* scales;             ///< (L, 3): s
  const std::array<bool, 3>* held;  ///< (L,), or null: coordinates that do not move
};

/// The factors of landmarks [begin, end).
void factor_landmarks(const LandmarkBlock* blocks,
                      const LandmarkDamping& damping,
                      std::int64_t begin,
                      std::int64_t end,
                      LandmarkFactor* factors);

/// max |g| over the coordinates of landmarks [begin, end) that are not held, NaN when one is not
/// finite.
double largest_gradient(const LandmarkBlock* blocks,
                        const std::array<bool, 3>* held,
                        std::int64_t begin,
                        std::int64_t end);

}  // namespace raylign::native
