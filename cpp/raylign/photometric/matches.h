// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// Whether an edge can be held to what it shows: in view, in the way of neither another point nor
/// the border, of a point whose patch can be told from others.
bool is_comparable(const Views& views, std::int64_t p, std::int64_t e);

/// What an image shows of the patches, before and after a refinement. Edges of a point with its own
/// host do not count. A point is confirmed to an image when more than half of the other images that
/// see it match its patch.
struct ImageMatch {
  std::int64_t num_edges = 0;   ///< comparable before or after
  std::int64_t num_before = 0;  ///< of them matched before
  std::int64_t num_after = 0;
  std::int64_t num_kept = 0;       ///< matched before and after
  std::int64_t num_tellable = 0;   ///< comparable after, of points that another image sees
  std::int64_t num_confirmed = 0;  ///< of those, points that the others confirm
  std::int64_t num_shown = 0;      ///< of those, matched after

  /// Whether the image is where it shows the patches. A right image matches most of the points that
  /// the others confirm, however many other points have gone astray; one that has been lost matches
  /// few of them, and where all is wrong hardly any point is confirmed. Two other ways to be right:
  /// half of all edges are matched, which is all that two images can say; or those that were
  /// matched at the start still are.
  bool is_right() const;
  /// With its numbers, for the user: "shows 3 % of …".
  std::string text() const;
};

/// Whether the residuals of an edge keep less than about a third of its patch's contrast (sums of
/// squares).
bool is_matched(const Views& views, std::int64_t p, std::int64_t e);

/// Of every image, by some of the points.
std::vector<ImageMatch> compare_matches(const Setting& setting,
                                        const Views& before,
                                        const Views& after,
                                        const std::vector<bool>& points);

}  // namespace raylign::photometric
