// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_pattern.h"

#include <algorithm>
#include <utility>

namespace raylign::native {
namespace {

// Landmarks of each camera, ascending, one entry per observation: starts (C + 1,), landmarks (N,).
std::pair<std::vector<std::int64_t>, std::vector<std::int32_t>> landmarks_by_camera(
    const Layout& layout) {
  std::vector<std::int64_t> starts(layout.num_cameras + 1, 0);
  for (const std::int32_t i : layout.camera) ++starts[i + 1];
  for (std::int32_t i = 0; i < layout.num_cameras; ++i) starts[i + 1] += starts[i];
  std::vector<std::int32_t> landmarks(layout.num_observations());
  std::vector<std::int64_t> next(starts.begin(), starts.end() - 1);
  for (std::int64_t j = 0; j < layout.num_landmarks(); ++j) {
    for (auto q = layout.starts[j]; q < layout.starts[j + 1]; ++q) {
      landmarks[next[layout.camera[q]]++] = static_cast<std::int32_t>(j);
    }
  }
  return {std::move(starts), std::move(landmarks)};
}

}  // namespace

SchurPattern::SchurPattern(const Layout& layout, std::vector<unsigned char> active_cameras)
    : active(std::move(active_cameras)) {
  const auto [track_starts, tracks] = landmarks_by_camera(layout);
  find_columns(layout, track_starts, tracks);
}

SchurPattern SchurPattern::diagonal(std::vector<unsigned char> active_cameras) {
  SchurPattern pattern;
  pattern.active = std::move(active_cameras);
  pattern.diagonal_only = true;
  pattern.starts.push_back(0);
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    if (pattern.active[i] != 0) pattern.columns.push_back(i);
    pattern.starts.push_back(pattern.num_blocks());
  }
  return pattern;
}

void SchurPattern::find_columns(const Layout& layout,
                                const std::vector<std::int64_t>& track_starts,
                                const std::vector<std::int32_t>& tracks) {
  std::vector<std::int32_t> marked_by(num_cameras(), -1);
  starts.push_back(0);
  for (std::int32_t i = 0; i < num_cameras(); ++i) {
    for (auto t = track_starts[i]; active[i] != 0 && t < track_starts[i + 1]; ++t) {
      const std::int64_t j = tracks[t];
      for (auto q = layout.starts[j + 1]; q-- > layout.starts[j] && layout.camera[q] >= i;) {
        const std::int32_t k = layout.camera[q];
        if (active[k] == 0) continue;
        ++num_pairs;
        if (marked_by[k] == i) continue;
        marked_by[k] = i;
        columns.push_back(k);
      }
    }
    std::sort(columns.begin() + starts.back(), columns.end());
    starts.push_back(num_blocks());
  }
}

std::int32_t SchurPattern::find(std::int32_t i, std::int32_t k) const {
  const auto begin = columns.begin();
  return static_cast<std::int32_t>(std::lower_bound(begin + starts[i], begin + starts[i + 1], k) -
                                   begin);
}

}  // namespace raylign::native
