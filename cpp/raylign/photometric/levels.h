// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// How many pyramid levels a solve starts with.
struct LevelPlan {
  int num_levels = 1;
  double expected_shift_px = -1.0;  ///< median over the edges, from the priors; −1: unknown
  std::vector<std::string> messages;
};

/// The coarsest level L is the first with expected shift / 2^L < 1.5 px, the widest start that one
/// level has been seen to recover from. Four levels when no prior tells the shift; one for stored
/// patches, which cannot be read again at a coarser level. Attempts may ask for more.
LevelPlan plan_levels(const Setting& setting, const PhotometricState& start);

}  // namespace raylign::photometric
