// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/patch_reader.h"
#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// How well an image shows a patch, over the pixels that count.
struct Match {
  double median_residual = 0.0;  ///< median |r|, grey levels
  double zncc = -1.0;            ///< zero-mean normalised cross-correlation
  double unexplained = 1.0;      ///< sum of r² over that of the patch's deviations from its mean
};
Match match_of(const PatchScene& scene, std::int64_t p, const PatchEdge& edge);

/// What the grey values say: marks edges as MISMATCH, sets the status of the points, and edges of
/// points that are not used to NOT_USED.
void judge(const Setting& setting, const PatchSources& sources, Views& views);

/// The stricter look at a final state: DIVERGED, where more than half of the views that a round has
/// let pass as near enough to converge show something else than the patch at this noise after all.
/// @param sigma  of a pixel's residual, grey levels
void mark_diverged(const Setting& setting, double sigma, Views& views);

}  // namespace raylign::photometric
