// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "raylign/photometric/matches.h"
#include "raylign/photometric/refinement.h"

namespace raylign::photometric {

/// Robust cost of the same edges at two states.
struct CostComparison {
  std::int64_t num_points = 0;
  std::int64_t num_edges = 0;  ///< in view at both
  std::int64_t num_lost = 0;   ///< in view before only
  double before = 0.0;  ///< mean over the edges of the mean of ½ρ(r²) over their pixels, grey²
  double after = 0.0;
};

/// @param points  which to look at
CostComparison compare_costs(const Setting& setting,
                             const Views& before,
                             const Views& after,
                             const std::vector<bool>& points,
                             const Loss& loss);

/// (M,) images that have moved and are not right: one that has not moved is no worse than it was.
std::vector<bool> lost_images(const std::vector<ImageMatch>& matches,
                              const PhotometricState& start,
                              const PhotometricState& refined);

struct Verdict {
  bool accepted = false;
  std::string reason;
  CostComparison costs;
};

/// Whether `refined` is better than `start`. The points held out of the solve are refined alone at
/// both states, cameras and brightness as they are there, so that each state may show the points
/// where it would put them; the edges they have in view at both are compared. Without enough of
/// them, the points of the solve are compared as they are. Refuses besides when an image is lost,
/// when a camera has moved by more than its prior allows, or when a number is not finite: a wrong
/// minimum costs less than a bad start, too.
/// @param matches  of every image, from start to refined
Verdict judge_refinement(const Setting& setting,
                         const PatchConstraints& base,
                         const RoundLaw& law,
                         int num_levels,
                         const std::vector<bool>& held_out,
                         const std::vector<ImageMatch>& matches,
                         const PhotometricState& start,
                         PhotometricState& refined);

}  // namespace raylign::photometric
