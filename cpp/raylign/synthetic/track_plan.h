// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/synthetic/bal_options.h"
#include "raylign/synthetic/track_sampler.h"

namespace raylign {

/// What must be known of every point before the first observation is written: four bytes each.
struct TrackPlan {
  std::vector<std::uint16_t> attempt;  ///< the draw that gave point j
  std::vector<std::uint16_t> length;   ///< its number of observations, >= 2
  std::int64_t num_observations = 0;
};

/// Draws all points once and fixes track lengths so that they sum to the total that the options
/// ask. Throws OptionsError when that cannot be reached.
TrackPlan plan_tracks(const SyntheticBalOptions& options, TrackSampler& sampler);

}  // namespace raylign
