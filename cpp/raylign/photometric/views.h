// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/photometric/hosts.h"
#include "raylign/photometric/noise_law.h"
#include "raylign/photometric/options.h"
#include "raylign/photometric/prepared_images.h"
#include "raylign/photometric/problem.h"
#include "raylign/photometric/result.h"
#include "raylign/photometric/state.h"

namespace raylign::photometric {

/// What stays the same from the first round to the last.
struct Setting {
  const PhotometricProblem& problem;
  const PhotometricOptions& options;
  ThreadPool& pool;
  PreparedImages prepared;
  PatchHosts hosts;
  Candidates candidates;

  std::int64_t num_points() const { return problem.num_points(); }
  bool is_host(std::int64_t point, std::int32_t image) const { return hosts.image[point] == image; }
};

/// Which images see which points at a state, how each patch is warped and where it is read: all
/// that a round decides, for every candidate.
struct Views {
  PatchScene scene;  ///< every candidate is an edge, whatever its status
  std::vector<EdgeStatus> edges;
  std::vector<PointStatus> points;
  Rows<double, 3> normals;  ///< (N, 3) used, host frame; NaN: none
};

/// @param level  the pyramid level that a patch of scale change 1 is read on; its pattern is spaced
///               in pixels of that level
Views find_views(const Setting& setting, const PhotometricState& state, int level);

/// The scene of a solve: of `views`, the edges that are OK of the points in `active`.
PatchScene used_scene(const Views& views, const std::vector<bool>& active);

/// Residuals of the pixels that count, of edges that are OK, of the points in `active`; without
/// those of the hosts.
std::vector<float> residuals_of(const Setting& setting,
                                const Views& views,
                                const std::vector<bool>& active);

/// Calls f(p) for every point below n, in chunks over the pool.
template <typename F>
void for_each_point(ThreadPool& pool, std::int64_t n, const F& f) {
  constexpr std::int64_t kChunk = 64;
  pool.run(static_cast<int>((n + kChunk - 1) / kChunk), [&](int chunk) {
    const std::int64_t last = std::min(n, (chunk + 1) * kChunk);
    for (std::int64_t p = chunk * kChunk; p < last; ++p) f(p);
  });
}

}  // namespace raylign::photometric
