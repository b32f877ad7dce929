// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/layout.h"

#include <algorithm>

#include "raylign/bundle/native/table.h"

namespace raylign::native {
namespace {

constexpr std::int64_t kMaxChunks = 16;
constexpr std::int64_t kMinObservationsPerChunk = 4096;

using Positions = Table<std::int32_t>;  // of observations: there are less than 2³¹

// The positions sorted by key(position), equal keys in their order: a counting sort.
template <typename Range, typename Key>
Positions sorted_by(const Range& positions, std::int64_t num_keys, Key key) {
  std::vector<std::int32_t> next(num_keys + 1, 0);
  for (const std::int32_t i : positions) ++next[key(i) + 1];
  for (std::int64_t k = 0; k < num_keys; ++k) next[k + 1] += next[k];
  Positions sorted(positions.size());
  for (const std::int32_t i : positions) sorted[next[key(i)]++] = i;
  return sorted;
}

// 0 … n − 1.
class Numbers {
 public:
  explicit Numbers(std::int64_t count) : count_(static_cast<std::int32_t>(count)) {}
  struct Iterator {
    std::int32_t i;
    std::int32_t operator*() const { return i; }
    void operator++() { ++i; }
    bool operator!=(const Iterator& other) const { return i != other.i; }
  };
  Iterator begin() const { return {0}; }
  Iterator end() const { return {count_}; }
  std::size_t size() const { return static_cast<std::size_t>(count_); }

 private:
  std::int32_t count_;
};

CameraKind camera_kind_of(CameraModel model) {
  switch (model) {
    case CameraModel::PINHOLE:
      return CameraKind::PINHOLE;
    case CameraModel::RADTAN:
      return CameraKind::RADTAN;
    case CameraModel::BAL:
      break;
  }
  return CameraKind::BAL;
}

}  // namespace

Layout::Layout(const BundleScene& scene, PointKind kind)
    : point_kind(kind),
      camera_kind(camera_kind_of(scene.camera_model)),
      num_cameras(static_cast<std::int32_t>(scene.num_cameras())) {
  const auto& cameras = scene.camera_index;
  const auto& point_of = scene.point_index;
  const auto by_camera = sorted_by(Numbers(scene.num_observations()), scene.num_cameras(),
                                   [&](std::int32_t i) { return cameras[i]; });
  const auto by_point =
      sorted_by(by_camera, scene.num_points(), [&](std::int32_t i) { return point_of[i]; });
  std::vector<std::int32_t> tracks;   // first position in by_point of each observed point
  std::vector<std::int32_t> highest;  // (P,) camera
  highest.resize(scene.num_points());
  const auto num_observations = static_cast<std::int32_t>(scene.num_observations());
  for (std::int32_t k = 0; k < num_observations; ++k) {
    const std::int32_t point = point_of[by_point[k]];
    if (k == 0 || point != point_of[by_point[k - 1]]) tracks.push_back(k);
    highest[point] = cameras[by_point[k]];
  }
  const auto by_highest = sorted_by(tracks, scene.num_cameras(),
                                    [&](std::int32_t k) { return highest[point_of[by_point[k]]]; });
  const auto ordered = sorted_by(by_highest, scene.num_cameras(),
                                 [&](std::int32_t k) { return cameras[by_point[k]]; });

  // first positions in the landmarks' order; `starts` knows their lengths from here on
  std::vector<std::int32_t> order(ordered.begin(), ordered.end());
  starts.reserve(order.size() + 1);
  starts.push_back(0);
  for (const std::int32_t first : order) {
    auto k = first;
    while (k < num_observations && point_of[by_point[k]] == point_of[by_point[first]]) ++k;
    starts.push_back(starts.back() + k - first);
  }
  cut_chunks();
  cut_windows();
  sort_by_length(order);

  points.reserve(order.size());
  camera.reserve(by_point.size());
  uv.reserve(2 * by_point.size());
  observed.assign(scene.num_cameras(), false);
  for (std::size_t j = 0; j < order.size(); ++j) {
    points.push_back(point_of[by_point[order[j]]]);
    for (auto k = order[j]; k < order[j] + starts[j + 1] - starts[j]; ++k) {
      const std::int32_t i = by_point[k];
      camera.push_back(cameras[i]);
      uv.push_back(scene.observations(i, 0));
      uv.push_back(scene.observations(i, 1));
      observed[cameras[i]] = true;
    }
  }
  sort_windows();
}

void Layout::cut_chunks() {
  const std::int64_t count = starts.back();
  const std::int64_t num_chunks =
      std::clamp<std::int64_t>(count / kMinObservationsPerChunk, 1, kMaxChunks);
  for (std::int64_t g = 0; g <= num_chunks; ++g) {
    const std::int64_t target = count * g / num_chunks;
    chunks.push_back(std::lower_bound(starts.begin(), starts.end(), target) - starts.begin());
  }
}

void Layout::cut_windows() {
  for (std::size_t g = 0; g + 1 < chunks.size(); ++g) {
    chunk_windows.push_back(static_cast<std::int32_t>(windows.size()));
    for (std::int64_t j = chunks[g]; j < chunks[g + 1];) {
      windows.push_back(j);
      const std::int64_t limit = starts[j] + kWindow;
      const bool alone = is_long(j++);
      while (!alone && j < chunks[g + 1] && !is_long(j) && starts[j + 1] <= limit) ++j;
    }
  }
  chunk_windows.push_back(static_cast<std::int32_t>(windows.size()));
  windows.push_back(static_cast<std::int64_t>(starts.size()) - 1);
}

// `order` and `starts` of each window, the longest tracks first, equal ones in their order.
void Layout::sort_by_length(std::vector<std::int32_t>& order) {
  std::vector<std::pair<std::int64_t, std::int32_t>> tracks;  // length, first position
  for (int w = 0; w < num_windows(); ++w) {
    tracks.clear();
    for (auto j = windows[w]; j < windows[w + 1]; ++j) {
      tracks.emplace_back(starts[j + 1] - starts[j], order[j]);
    }
    std::stable_sort(tracks.begin(), tracks.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    auto j = windows[w];
    for (const auto& [length, first] : tracks) {
      order[j] = first;
      starts[j + 1] = starts[j] + length;
      ++j;
    }
  }
}

void Layout::sort_windows() {
  places.resize(num_observations());
  std::vector<std::int32_t> next(num_cameras, 0);
  std::vector<std::int32_t> seen;
  window_visits.push_back(0);
  for (int w = 0; w < num_windows(); ++w) {
    const std::int64_t begin = starts[windows[w]];
    const std::int64_t end = starts[windows[w + 1]];
    for (auto q = begin; q < end; ++q) {
      if (next[camera[q]]++ == 0) seen.push_back(camera[q]);
    }
    std::sort(seen.begin(), seen.end());
    std::int32_t sum = 0;
    for (const std::int32_t i : seen) {
      const std::int32_t first = sum;
      sum += next[i];
      next[i] = first;
      visits.push_back({i, sum});
    }
    for (auto q = begin; q < end; ++q) {
      places[begin + next[camera[q]]++] = static_cast<std::int32_t>(q - begin);
    }
    for (const std::int32_t i : seen) next[i] = 0;
    seen.clear();
    window_visits.push_back(static_cast<std::int64_t>(visits.size()));
  }
}

std::pair<std::int32_t, std::int32_t> Layout::camera_range(int chunk) const {
  std::int32_t first = num_cameras;
  std::int32_t last = -1;
  for (auto w = chunk_windows[chunk]; w < chunk_windows[chunk + 1]; ++w) {
    first = std::min(first, visits[window_visits[w]].camera);
    last = std::max(last, visits[window_visits[w + 1] - 1].camera);
  }
  return {std::min(first, last + 1), last + 1};
}

std::int64_t Layout::max_window() const {
  std::int64_t largest = 0;
  for (int w = 0; w < num_windows(); ++w) {
    largest = std::max(largest, starts[windows[w + 1]] - starts[windows[w]]);
  }
  return largest;
}

std::int64_t Layout::max_track_length() const {
  std::int64_t longest = 0;
  for (std::int64_t j = 0; j < num_landmarks(); ++j) {
    longest = std::max(longest, starts[j + 1] - starts[j]);
  }
  return longest;
}

}  // namespace raylign::native
