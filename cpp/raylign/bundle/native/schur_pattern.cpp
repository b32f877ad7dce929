// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_pattern.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "raylign/bundle/native/parallel.h"
#include "raylign/bundle/native/window_tracks.h"

namespace raylign::native {
namespace {

constexpr std::int32_t kRowsPerTask = 32;

struct CameraRange {
  std::int32_t begin, end;
};

// Which cameras of each window see a landmark together: rows of bits, one per visit.
class WindowRows {
 public:
  WindowRows(const Layout& layout, const std::vector<unsigned char>& active, ThreadPool& pool)
      : layout_(layout), active_(active), rows_(layout.num_windows()), pairs_(layout.num_chunks()) {
    chunk_bits_.resize(layout.num_chunks());
    run_tasks(pool, layout.num_chunks(), [&](int g) { fill_chunk(g); });
  }

  std::int64_t num_pairs() const {
    return std::accumulate(pairs_.begin(), pairs_.end(), std::int64_t{0});
  }

  /// Calls visit(k) for the moving cameras k >= camera that share a landmark with the c-th camera
  /// of the window, a moving one.
  template <typename Visit>
  void for_each_camera(int window, std::int64_t c, const Visit& visit) const {
    const CameraVisit* visits = layout_.visits.data() + layout_.window_visits[window];
    const std::int64_t count = layout_.window_visits[window + 1] - layout_.window_visits[window];
    if (rows_[window] == nullptr) {  // a long track: all of them
      for (auto k = c; k < count; ++k) {
        if (active_[visits[k].camera] != 0) visit(visits[k].camera);
      }
      return;
    }
    const auto num_words = static_cast<int>((count + 63) / 64);
    WindowTracks::for_each_bit(rows_[window] + c * num_words, num_words,
                               [&](int k) { visit(visits[k].camera); });
  }

 private:
  void fill_chunk(int chunk) {
    WindowTracks tracks(layout_, active_);
    std::vector<std::uint64_t>& bits = chunk_bits_[chunk];
    std::vector<std::size_t> places;
    const std::int32_t begin = layout_.chunk_windows[chunk];
    const std::int32_t end = layout_.chunk_windows[chunk + 1];
    for (auto w = begin; w < end; ++w) {
      places.push_back(bits.size());
      if (layout_.is_long(layout_.windows[w])) {
        pairs_[chunk] += pairs_of_long_track(w);
        continue;
      }
      tracks.load(w);
      bits.insert(bits.end(), tracks.rows().begin(), tracks.rows().end());
      pairs_[chunk] += tracks.num_products();
    }
    for (auto w = begin; w < end; ++w) {
      const bool is_long = layout_.is_long(layout_.windows[w]);
      rows_[w] = is_long ? nullptr : bits.data() + places[w - begin];
    }
  }

  std::int64_t pairs_of_long_track(int window) const {
    std::int64_t pairs = 0;
    std::int64_t met = 0;
    std::int32_t before = 0;
    for (auto v = layout_.window_visits[window]; v < layout_.window_visits[window + 1]; ++v) {
      const CameraVisit& visit = layout_.visits[v];
      const std::int64_t sights = visit.end - std::exchange(before, visit.end);
      if (active_[visit.camera] == 0) continue;
      pairs += sights * met + sights * sights;
      met += sights;
    }
    return pairs;
  }

  const Layout& layout_;
  const std::vector<unsigned char>& active_;
  std::vector<const std::uint64_t*> rows_;  // of each window; null: a long track
  std::vector<std::int64_t> pairs_;         // of each chunk
  std::vector<std::vector<std::uint64_t>> chunk_bits_;
};

// The visits of each camera to windows.
struct VisitsByCamera {
  struct Place {
    std::int32_t window;
    std::int32_t visit;  // counted from the window's first
  };
  std::vector<std::int64_t> starts;  // (C + 1,)
  std::vector<Place> places;

  explicit VisitsByCamera(const Layout& layout)
      : starts(layout.num_cameras + 1, 0), places(layout.visits.size()) {
    for (const CameraVisit& visit : layout.visits) ++starts[visit.camera + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::int64_t> next(starts.begin(), starts.end() - 1);
    for (int w = 0; w < layout.num_windows(); ++w) {
      for (auto v = layout.window_visits[w]; v < layout.window_visits[w + 1]; ++v) {
        places[next[layout.visits[v].camera]++] = {
            w, static_cast<std::int32_t>(v - layout.window_visits[w])};
      }
    }
  }
};

// Columns of the rows, appended to `columns`; their number goes to counts[row].
void find_columns(const WindowRows& rows,
                  const VisitsByCamera& visits,
                  const SchurPattern& pattern,
                  CameraRange range,
                  std::vector<std::int32_t>& columns,
                  std::int64_t* counts) {
  std::vector<std::uint64_t> bits((pattern.num_cameras() + 63) / 64, 0);
  for (auto i = range.begin; i < range.end; ++i) {
    counts[i] = 0;
    if (pattern.active[i] == 0) continue;
    std::int32_t last = i;
    for (auto p = visits.starts[i]; p < visits.starts[i + 1]; ++p) {
      const auto& place = visits.places[p];
      rows.for_each_camera(place.window, place.visit, [&](std::int32_t k) {
        bits[k / 64] |= std::uint64_t{1} << (k % 64);
        last = std::max(last, k);
      });
    }
    const std::size_t size = columns.size();
    const std::int32_t first_word = i / 64;
    WindowTracks::for_each_bit(bits.data() + first_word, last / 64 - first_word + 1,
                               [&](int k) { columns.push_back(64 * first_word + k); });
    std::fill(bits.begin() + first_word, bits.begin() + last / 64 + 1, 0);
    counts[i] = static_cast<std::int64_t>(columns.size() - size);
  }
}

}  // namespace

SchurPattern::SchurPattern(const Layout& layout, std::vector<unsigned char> active_cameras)
    : SchurPattern(layout, std::move(active_cameras), *std::make_unique<ThreadPool>(1)) {}

SchurPattern::SchurPattern(const Layout& layout,
                           std::vector<unsigned char> active_cameras,
                           ThreadPool& pool)
    : active(std::move(active_cameras)), starts(active.size() + 1, 0) {
  const WindowRows rows(layout, active, pool);
  num_pairs = rows.num_pairs();
  const VisitsByCamera visits(layout);
  const int num_parts = (num_cameras() + kRowsPerTask - 1) / kRowsPerTask;
  std::vector<std::vector<std::int32_t>> pieces(num_parts);
  run_tasks(pool, num_parts, [&](int part) {
    const std::int32_t begin = part * kRowsPerTask;
    const std::int32_t end = std::min(begin + kRowsPerTask, num_cameras());
    find_columns(rows, visits, *this, {begin, end}, pieces[part], starts.data() + 1);
  });
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  columns.reserve(starts.back());
  for (const auto& piece : pieces) columns.insert(columns.end(), piece.begin(), piece.end());
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

std::int32_t SchurPattern::find(std::int32_t i, std::int32_t k) const {
  const auto begin = columns.begin();
  return static_cast<std::int32_t>(std::lower_bound(begin + starts[i], begin + starts[i + 1], k) -
                                   begin);
}

}  // namespace raylign::native
