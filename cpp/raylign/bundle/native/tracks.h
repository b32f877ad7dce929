// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/table.h"
#include "raylign/scene/bundle_scene.h"

namespace raylign::native {

/// The observations of one point.
struct Track {
  std::int32_t point;
  std::int32_t first, length;    ///< positions [first, first + length) of Tracks::observation
  std::int32_t lowest, highest;  ///< camera
};

/// The points that somebody sees, by their lowest camera, then by their highest, then by number,
/// and the observations of each by camera, equal ones as the problem lists them. Positions are
/// int32: a problem has less than 2³¹ observations.
struct Tracks {
  Tracks(const BundleScene& scene, ThreadPool& pool);

  std::int32_t observation(std::int32_t position) const {
    return order.empty() ? position : order[position];
  }

  Table<Track> sorted;
  Table<std::int32_t> order;  ///< (N,) observations by point and camera; empty: they stand so
};

}  // namespace raylign::native
