// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

namespace raylign {

/// Similarity S = [sR t; 0 1] that minimises Σ_i ‖target_i − S source_i‖². Umeyama, PAMI 1991, eqs.
/// (40)-(43); with_scale = false holds s = 1. At least three points, not all on one line:
/// ShapeError for fewer rows or different lengths, Error for points that do not determine the
/// rotation or are not finite.
Matrix4 umeyama(const Rows<double, 3>& source,
                const Rows<double, 3>& target,
                bool with_scale = true);

}  // namespace raylign
