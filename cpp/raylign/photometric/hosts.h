// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/photometric/options.h"
#include "raylign/photometric/prepared_images.h"
#include "raylign/photometric/problem.h"
#include "raylign/photometric/state.h"

namespace raylign::photometric {

/// Where each patch comes from: an image and the pixel it is centred on.
struct PatchHosts {
  std::vector<std::int32_t> image;  ///< (N,) −1: a stored patch, or no image sees the point
  Rows<double, 2> uv;               ///< (N, 2) px; NaN where there is none

  bool any() const;
};

/// As the problem says; else, for a point without a stored patch, of the images that may see it the
/// one that sees it with the most contrast from the middle of all directions, and where the point
/// projects to.
PatchHosts choose_hosts(const PhotometricProblem& problem,
                        const PhotometricOptions& options,
                        const PreparedImages& prepared,
                        const PhotometricState& start);

/// Which images may see which point, point by point, images in ascending order.
struct Candidates {
  std::vector<std::int64_t> starts;  ///< (N + 1,)
  std::vector<std::int32_t> image;

  std::int64_t size() const { return static_cast<std::int64_t>(image.size()); }
};

/// The problem's tracks and each point's host, or every image. With inverse depth without the host,
/// whose own patch is where it is whatever moves.
Candidates list_candidates(const PhotometricProblem& problem,
                           const PhotometricOptions& options,
                           const PatchHosts& hosts);

/// Contrast of the image where a patch would be: standard deviation, grey levels; −1 where the
/// patch is not inside.
double contrast_at(const PatchImage& image,
                   SampleInterpolation interpolation,
                   const PatchPattern& pattern,
                   const Vector2& uv);

}  // namespace raylign::photometric
