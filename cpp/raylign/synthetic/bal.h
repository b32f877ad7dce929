// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/eigen.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/synthetic/bal_options.h"

namespace raylign {

/// A problem and its answer.
struct SyntheticBal {
  BalProblem problem;                 ///< perturbed start; observations with noise and outliers
  BalProblem truth;                   ///< the same observations; true cameras and points
  Rows<std::uint8_t, 1> inlier_mask;  ///< (N,) 0 for outliers
  SyntheticBalOptions options;
};

/// Generates a BAL problem in memory. Throws OptionsError (see SyntheticBalStream). The bits depend
/// on the options alone. Cost: about a microsecond per observation.
SyntheticBal synthetic_bal(const SyntheticBalOptions& options);

}  // namespace raylign
