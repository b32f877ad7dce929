// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/tracking/kernels.h"

namespace raylign::tracking {

/// Cells of a (height, width) map of marked depth (DepthPyramid's rule: V > 0 is depth). Slopes are
/// central differences where both neighbours lie on the pixel's surface, one-sided where one does,
/// else zero. Pixels are one surface when they differ by no more than 5 % or three standard
/// deviations of a difference; four that are not are no basis for interpolation. Nor are those of
/// the outermost rows and columns.
void make_depth_cells(const float* D, const float* V, int width, int height, DepthCell* cells);

}  // namespace raylign::tracking
