// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "raylign/photometric/matches.h"
#include "raylign/photometric/refinement.h"

namespace raylign::photometric {

/// A refinement from the start, and what each image shows after it.
struct Attempt {
  PhotometricState state;
  int num_levels = 1;
  RoundLaw law;
  std::vector<ImageMatch> matches;  ///< (M,)
};

/// Refines; where images end that do not show the patches, the way of a start too far off, tries
/// again before the result is refused. A good start costs nothing but the look at it.
class Attempts {
 public:
  /// @param active  the points that are solved for
  Attempts(const Setting& setting,
           const PatchConstraints& base,
           const PhotometricState& start,
           const std::vector<bool>& active,
           Progress& progress,
           Refinement& refinement);

  /// The attempt that loses fewest images, the first of them: `refinement` has its law. With levels
  /// that the caller's options do not fix: images that are lost while most are right are looked for
  /// by the points that the right ones agree on; then all again from the start on all levels.
  Attempt run(int num_levels);

  const Views& before() const { return before_; }  ///< at the start, on level 0
  const std::vector<std::string>& messages() const { return messages_; }  ///< for the user

 private:
  Attempt refine(PhotometricState from, int num_levels);
  Attempt with_found_images(Attempt attempt);
  int num_lost(const Attempt& attempt) const;

  const Setting& setting_;
  const PatchConstraints& base_;
  const PhotometricState& start_;
  const std::vector<bool>& active_;
  Progress& progress_;
  Refinement& refinement_;
  Views before_;
  std::vector<std::string> messages_;
};

}  // namespace raylign::photometric
