// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_pattern.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace raylign::native {
namespace {

// Half of these entries per observation at most: 32 bytes.
constexpr std::int64_t kMaxTabulated = 32;

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
  std::int64_t longest_row = 0;
  for (std::int32_t i = 0; i < num_cameras(); ++i) {
    longest_row = std::max(longest_row, starts[i + 1] - starts[i]);
  }
  if (longest_row > std::numeric_limits<std::uint16_t>::max()) return;
  max_tabulated = kMaxTabulated;
  find_places(layout, track_starts, tracks);
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

void SchurPattern::find_places(const Layout& layout,
                               const std::vector<std::int64_t>& track_starts,
                               const std::vector<std::int32_t>& tracks) {
  std::vector<std::int64_t> first_pair(layout.num_landmarks() + 1, 0);
  for (std::int64_t j = 0; j < layout.num_landmarks(); ++j) {
    const std::int64_t length = layout.starts[j + 1] - layout.starts[j];
    first_pair[j + 1] = first_pair[j] + (length <= max_tabulated ? length * (length + 1) / 2 : 0);
  }
  places.resize(first_pair.back());
  std::vector<std::uint16_t> place(num_cameras(), 0);
  for (std::int32_t i = 0; i < num_cameras(); ++i) {
    for (auto b = starts[i]; b < starts[i + 1]; ++b) {
      place[columns[b]] = static_cast<std::uint16_t>(b - starts[i]);
    }
    for (auto t = track_starts[i]; active[i] != 0 && t < track_starts[i + 1]; ++t) {
      const std::int64_t j = tracks[t];
      const std::int32_t* track = layout.camera.data() + layout.starts[j];
      const std::int64_t length = layout.starts[j + 1] - layout.starts[j];
      if (length > max_tabulated) continue;
      std::uint16_t* out = places.data() + first_pair[j];
      for (std::int64_t a = 0; a < length && track[a] <= i; out += length - a, ++a) {
        for (std::int64_t b = a; track[a] == i && b < length; ++b) out[b - a] = place[track[b]];
      }
    }
  }
}

}  // namespace raylign::native
