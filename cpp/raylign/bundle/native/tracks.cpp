// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/tracks.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "raylign/bundle/native/parallel.h"

namespace raylign::native {
namespace {

using Positions = Table<std::int32_t>;

// Counts, one per range, become where each range begins.
std::int64_t sum_before(std::vector<std::int64_t>& counts) {
  std::int64_t sum = 0;
  for (std::int64_t& count : counts) sum += std::exchange(count, sum);
  return sum;
}

// Whether the observations stand by point, those of a point by camera.
bool is_in_order(const BundleScene& scene, ThreadPool& pool) {
  const std::int32_t* points = scene.point_index.data();
  const std::int32_t* cameras = scene.camera_index.data();
  const Ranges ranges(pool, scene.num_observations());
  std::vector<int> descents(ranges.size(), 0);
  pool.run(ranges.size(), [&](int r) {
    int found = 0;
    for (auto i = std::max<std::int64_t>(1, ranges.begin(r)); i < ranges.end(r); ++i) {
      const bool same = points[i - 1] == points[i];
      found |= (points[i - 1] > points[i]) | (same & (cameras[i - 1] > cameras[i]));
    }
    descents[r] = found;
  });
  return std::all_of(descents.begin(), descents.end(), [](int found) { return found == 0; });
}

// First position of each point and the end of the last, of observations that stand by point.
Positions find_firsts(const BundleScene& scene, ThreadPool& pool) {
  const std::int32_t* points = scene.point_index.data();
  Positions firsts(scene.num_points() + 1);
  const Ranges ranges(pool, scene.num_observations());
  pool.run(ranges.size(), [&](int r) {
    std::int32_t next = ranges.begin(r) == 0 ? 0 : points[ranges.begin(r) - 1] + 1;
    for (auto i = ranges.begin(r); i < ranges.end(r); ++i) {
      while (next <= points[i]) firsts[next++] = static_cast<std::int32_t>(i);
    }
    if (r + 1 < ranges.size()) return;
    std::fill(firsts.begin() + next, firsts.end(), static_cast<std::int32_t>(ranges.end(r)));
  });
  return firsts;
}

// The same for observations in any order, and that order: by point, then by camera. Each thread
// sorts the points of its range and passes over the others.
Positions sort_observations(const BundleScene& scene, ThreadPool& pool, Positions& order) {
  const auto count = static_cast<std::int32_t>(scene.num_observations());
  const std::int32_t* points = scene.point_index.data();
  const std::int32_t* cameras = scene.camera_index.data();
  const Ranges ranges(pool, scene.num_points());
  const auto for_each_of = [&](int r, const auto& visit) {
    const auto begin = static_cast<std::int32_t>(ranges.begin(r));
    const auto end = static_cast<std::int32_t>(ranges.end(r));
    for (std::int32_t i = 0; i < count; ++i) {
      if (begin <= points[i] && points[i] < end) visit(i);
    }
  };
  Positions firsts(scene.num_points() + 1);
  order.resize(count);
  firsts[0] = 0;
  std::vector<std::int64_t> starts(ranges.size(), 0);
  pool.run(ranges.size(), [&](int r) {
    std::fill(firsts.begin() + ranges.begin(r) + 1, firsts.begin() + ranges.end(r) + 1, 0);
    for_each_of(r, [&](std::int32_t i) { ++firsts[points[i] + 1]; });
    for (auto p = ranges.begin(r); p < ranges.end(r); ++p) starts[r] += firsts[p + 1];
  });
  sum_before(starts);
  pool.run(ranges.size(), [&](int r) {
    auto sum = static_cast<std::int32_t>(starts[r]);
    for (auto p = ranges.begin(r); p < ranges.end(r); ++p) {
      sum += std::exchange(firsts[p + 1], sum);  // until the end of the next loop: where p begins
    }
    for_each_of(r, [&](std::int32_t i) { order[firsts[points[i] + 1]++] = i; });
    auto begin = order.begin() + starts[r];
    const auto by_camera = [&](std::int32_t a, std::int32_t b) {
      return cameras[a] != cameras[b] ? cameras[a] < cameras[b] : a < b;
    };
    for (auto p = ranges.begin(r); p < ranges.end(r); ++p) {
      const auto end = order.begin() + firsts[p + 1];
      if (!std::is_sorted(begin, end, by_camera)) std::sort(begin, end, by_camera);
      begin = end;
    }
  });
  return firsts;
}

// Sorted by key(track), equal keys in their order: a counting sort, a part of the input per thread.
template <typename Key>
void sort_by(Table<Track>& tracks, std::int64_t num_keys, ThreadPool& pool, Key key) {
  const Ranges ranges(pool, static_cast<std::int64_t>(tracks.size()));
  std::vector<std::int32_t> next(ranges.size() * num_keys, 0);
  pool.run(ranges.size(), [&](int r) {
    std::int32_t* counts = next.data() + r * num_keys;
    for (auto j = ranges.begin(r); j < ranges.end(r); ++j) ++counts[key(tracks[j])];
  });
  std::int32_t sum = 0;
  for (std::int64_t k = 0; k < num_keys; ++k) {
    for (int r = 0; r < ranges.size(); ++r) sum += std::exchange(next[r * num_keys + k], sum);
  }
  Table<Track> sorted(tracks.size());
  pool.run(ranges.size(), [&](int r) {
    std::int32_t* places = next.data() + r * num_keys;
    for (auto j = ranges.begin(r); j < ranges.end(r); ++j) {
      sorted[places[key(tracks[j])]++] = tracks[j];
    }
  });
  tracks.swap(sorted);
}

}  // namespace

Tracks::Tracks(const BundleScene& scene, ThreadPool& pool) {
  const Positions firsts =
      is_in_order(scene, pool) ? find_firsts(scene, pool) : sort_observations(scene, pool, order);
  const Ranges ranges(pool, scene.num_points());
  std::vector<std::int64_t> starts(ranges.size(), 0);
  pool.run(ranges.size(), [&](int r) {
    std::int64_t count = 0;
    for (auto p = ranges.begin(r); p < ranges.end(r); ++p) count += firsts[p] < firsts[p + 1];
    starts[r] = count;
  });
  sorted.resize(sum_before(starts));
  pool.run(ranges.size(), [&](int r) {
    Track* next = sorted.data() + starts[r];
    for (auto p = ranges.begin(r); p < ranges.end(r); ++p) {
      const std::int32_t first = firsts[p];
      const std::int32_t end = firsts[p + 1];
      if (first == end) continue;
      *next++ = {static_cast<std::int32_t>(p), first, end - first,
                 scene.camera_index[observation(first)], scene.camera_index[observation(end - 1)]};
    }
  });
  sort_by(sorted, scene.num_cameras(), pool, [](const Track& track) { return track.highest; });
  sort_by(sorted, scene.num_cameras(), pool, [](const Track& track) { return track.lowest; });
}

}  // namespace raylign::native
