// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/layout.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "raylign/bundle/native/parallel.h"
#include "raylign/bundle/native/table.h"

namespace raylign::native {
namespace {

constexpr std::int64_t kMaxChunks = 16;
constexpr std::int64_t kMinObservationsPerChunk = 4096;

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

// Fills what of a layout belongs to one chunk. What has no place yet, because its length is not
// known before, is kept until all chunks are through.
class ChunkFiller {
 public:
  void fill(Layout& layout, const BundleScene& scene, Tracks& tracks, int chunk) {
    cut_windows(layout, layout.chunks[chunk], layout.chunks[chunk + 1]);
    next_.assign(layout.num_cameras, 0);
    for (std::size_t w = 0; w + 1 < windows_.size(); ++w) {
      sort_by_length(layout, tracks, windows_[w], windows_[w + 1]);
    }
    for (std::size_t w = 0; w + 1 < windows_.size(); ++w) {
      copy_observations(layout, scene, tracks, windows_[w], windows_[w + 1]);
      sort_by_camera(layout, windows_[w], windows_[w + 1]);
    }
  }

  void append_to(Layout& layout) const {
    const auto first_visit = static_cast<std::int64_t>(layout.visits.size());
    layout.chunk_windows.push_back(static_cast<std::int32_t>(layout.windows.size()));
    for (std::size_t w = 0; w + 1 < windows_.size(); ++w) {
      layout.windows.push_back(windows_[w]);
      layout.window_visits.push_back(first_visit + window_visits_[w]);
    }
    layout.visits.insert(layout.visits.end(), visits_.begin(), visits_.end());
    for (const CameraVisit& visit : visits_) layout.observed[visit.camera] = true;
  }

 private:
  void cut_windows(const Layout& layout, std::int64_t begin, std::int64_t end) {
    const auto& starts = layout.starts;
    for (std::int64_t j = begin; j < end;) {
      windows_.push_back(j);
      const std::int64_t limit = starts[j] + Layout::kWindow;
      const bool alone = layout.is_long(j++);
      while (!alone && j < end && !layout.is_long(j) && starts[j + 1] <= limit) ++j;
    }
    windows_.push_back(end);
  }

  // The tracks [begin, end) of a window, the longest first, equal ones in their order: a counting
  // sort. A long track is alone and stays.
  void sort_by_length(Layout& layout, Tracks& tracks, std::int64_t begin, std::int64_t end) {
    if (end - begin == 1) return;
    std::int32_t next[Layout::kLongTrack + 1] = {};
    const auto sorted = tracks.sorted.begin();
    unsorted_.assign(sorted + begin, sorted + end);
    for (const Track& track : unsorted_) ++next[track.length];
    std::int32_t sum = 0;
    for (auto length = Layout::kLongTrack; length > 0; --length) {
      sum += std::exchange(next[length], sum);
    }
    for (const Track& track : unsorted_) sorted[begin + next[track.length]++] = track;
    for (auto j = begin; j + 1 < end; ++j) {  // the last one ends where the window does
      layout.starts[j + 1] = layout.starts[j] + sorted[j].length;
    }
  }

  void copy_observations(Layout& layout,
                         const BundleScene& scene,
                         const Tracks& tracks,
                         std::int64_t begin,
                         std::int64_t end) {
    constexpr std::int64_t kAhead = 8;
    const std::int32_t* cameras = scene.camera_index.data();
    const double* uv = scene.observations.data();
    for (auto j = begin; j < end; ++j) {
      if (j + kAhead < windows_.back()) {  // elsewhere in the problem: memory takes its time
        const std::int32_t i = tracks.observation(tracks.sorted[j + kAhead].first);
        __builtin_prefetch(cameras + i);
        __builtin_prefetch(uv + 2 * std::int64_t{i});
        __builtin_prefetch(uv + 2 * std::int64_t{i} + 8);
      }
      const Track& track = tracks.sorted[j];
      layout.points[j] = track.point;
      std::int64_t q = layout.starts[j];
      for (auto k = track.first; k < track.first + track.length; ++k, ++q) {
        const std::int64_t i = tracks.observation(k);
        layout.camera[q] = cameras[i];
        layout.uv[2 * q] = uv[2 * i];
        layout.uv[2 * q + 1] = uv[2 * i + 1];
      }
    }
  }

  void sort_by_camera(Layout& layout, std::int64_t first_landmark, std::int64_t end_landmark) {
    const std::int64_t begin = layout.starts[first_landmark];
    const std::int64_t end = layout.starts[end_landmark];
    window_visits_.push_back(static_cast<std::int64_t>(visits_.size()));
    seen_.clear();
    for (auto q = begin; q < end; ++q) {
      if (next_[layout.camera[q]]++ == 0) seen_.push_back(layout.camera[q]);
    }
    std::sort(seen_.begin(), seen_.end());
    std::int32_t sum = 0;
    for (const std::int32_t i : seen_) {
      const std::int32_t count = std::exchange(next_[i], sum);
      sum += count;
      visits_.push_back({i, sum});
    }
    for (auto q = begin; q < end; ++q) {
      layout.places[begin + next_[layout.camera[q]]++] = static_cast<std::int32_t>(q - begin);
    }
    for (const std::int32_t i : seen_) next_[i] = 0;
  }

  std::vector<std::int64_t> windows_;        // first landmarks, and where the last ends
  std::vector<std::int64_t> window_visits_;  // counted from the chunk's first
  std::vector<CameraVisit> visits_;
  std::vector<std::int32_t> next_;  // (C,)
  std::vector<std::int32_t> seen_;
  std::vector<Track> unsorted_;
};

}  // namespace

Layout::Layout(const BundleScene& scene, PointKind kind)
    : Layout(scene, kind, *std::make_unique<ThreadPool>(1)) {}

Layout::Layout(const BundleScene& scene, PointKind kind, ThreadPool& pool)
    : point_kind(kind),
      camera_kind(camera_kind_of(scene.camera_model)),
      num_cameras(static_cast<std::int32_t>(scene.num_cameras())),
      observed(scene.num_cameras(), false) {
  Tracks tracks(scene, pool);
  starts.resize(tracks.sorted.size() + 1);
  starts[0] = 0;
  for (std::size_t j = 0; j < tracks.sorted.size(); ++j) {
    starts[j + 1] = starts[j] + tracks.sorted[j].length;
  }
  cut_chunks();
  fill_chunks(scene, tracks, pool);
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

void Layout::fill_chunks(const BundleScene& scene, Tracks& tracks, ThreadPool& pool) {
  points.resize(tracks.sorted.size());
  camera.resize(scene.num_observations());
  uv.resize(2 * scene.num_observations());
  places.resize(scene.num_observations());
  std::vector<ChunkFiller> fillers(num_chunks());
  run_tasks(pool, num_chunks(), [&](int g) { fillers[g].fill(*this, scene, tracks, g); });
  for (const ChunkFiller& filler : fillers) filler.append_to(*this);
  chunk_windows.push_back(static_cast<std::int32_t>(windows.size()));
  windows.push_back(num_landmarks());
  window_visits.push_back(static_cast<std::int64_t>(visits.size()));
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
